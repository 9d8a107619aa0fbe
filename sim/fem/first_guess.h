#pragma once

#include <optional>
#include <vector>

#include "sim/fem/boundary.h"
#include "sim/fem/time_integrator.h"

namespace wry::fem {

/// Where Newton's method begins.
struct FirstGuess {
  Trial trial;
  std::optional<Trial> given; ///< where held unknowns have to go from there
};

/// The expected velocities, shortened where they would pass an obstacle; where the step starts if they would invert
/// elements. Where drives alone would pass an obstacle or invert elements (`driven`: there are any), they are left to
/// be taken along. `state` is where the step starts, free of intersections.
FirstGuess first_guess(const PlannedStage& planned, const FemState& state, const Boundary& boundary,
                       const std::vector<EnergyTerm*>& terms, bool driven);

} // namespace wry::fem
