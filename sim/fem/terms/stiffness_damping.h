#pragma once

#include <memory>

#include "sim/fem/body_elements.h"

namespace wry::fem {

/// The elements of a body, and its damping [s].
struct DampedElements {
  const BodyElements* elements = nullptr;
  double damping = 0.0;
};

/// beta/2 u^T C u with C = sum of damping x the elements' stiffness, projected to positive, where the step is expected
/// to end: a force of -C u, frozen during a solve. u are all unknowns. Costs a second matrix and its assembly per step.
std::unique_ptr<EnergyTerm> make_stiffness_damping(const FemModel& model, std::vector<DampedElements> damped,
                                                   std::unique_ptr<BlockMatrix> matrix, const Threads& threads);

} // namespace wry::fem
