#pragma once

#include "sim/fem/boundary.h"

namespace wry::fem {

/// What holds, drives and springs exert on the nodes at the end of a step.
struct Reactions {
  Points forces;  ///< per node [N]; zero at free nodes. Empty before the first step
  Points torques; ///< per node [N m], on the microrotations; empty without
};

/// From the converged trial of a step's last stage of length `dt`: what the elements, loads and contacts demand, and
/// the inertia of the matter at given nodes along their motion.
Reactions measure_reactions(const FemModel& model, const std::vector<EnergyTerm*>& terms, const Boundary& boundary,
                            const Stage& stage, const Trial& trial);

} // namespace wry::fem
