#pragma once

#include <string>

#include "sim/fem/fem_scene.h"
#include "sim/fem/fem_simulation.h"
#include "sim/fem/fem_state.h"

namespace wry::fem {

/// A state as a trial of no length, for what is evaluated where matter is.
Trial trial_at_rest_in(const FemState& state);

/// Adds the energies of a state to those of `stats` [J].
void add_energies(const FemScene& scene, const FemState& state, StepStats& stats);

/// "; body 'skin': tet 12 (vertices 3 4 5 9) has the volume ...", of the first tet of a solid with no volume left or
/// the wrong sign; empty where there is none.
std::string describe_inverted(const FemPlan& plan, const FemScene& scene, const FemState& state);

} // namespace wry::fem
