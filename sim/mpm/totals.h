#pragma once

#include <vector>

#include "sim/mpm/mpm_simulation.h"
#include "sim/mpm/mpm_state.h"

namespace wry::mpm {

/// Mass, momenta and energies of all particles.
template <class Scalar>
Totals sum_totals(const MpmPlan& plan, const std::vector<BodyState<Scalar>>& bodies, const MpmState<Scalar>& state);

} // namespace wry::mpm
