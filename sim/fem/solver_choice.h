#pragma once

#include "sim/fem/fem_scene.h"
#include "sim/fem/fem_simulation.h"
#include "sim/fem/linear/linear_method.h"

namespace wry::fem {

/// A linear method and why it was taken.
struct ChosenMethod {
  SolverChoice choice;
  std::unique_ptr<LinearMethod> method;
};

/// What the plan asks for; `automatic` weighs mesh size, fill of a factor and stiffness against the step.
/// Errors: unavailable when a direct solver is asked for and this build has none.
Result<ChosenMethod> choose_linear_method(const FemPlan& plan, const FemScene& scene, const BlockMatrix& matrix,
                                          const Threads& threads);

} // namespace wry::fem
