#include "sim/fem/first_guess.h"

#include <algorithm>
#include <cmath>

#include "sim/fem/newton.h"

namespace wry::fem {

namespace {

constexpr int PASSES = 3;

bool is_finite(const Stage& stage, const Trial& at, const std::vector<EnergyTerm*>& terms) {
  return std::all_of(terms.begin(), terms.end(),
                     [&](const EnergyTerm* term) { return std::isfinite(term->energy(stage, at)); });
}

} // namespace

FirstGuess first_guess(const PlannedStage& planned, const FemState& state, const Boundary& boundary,
                       const std::vector<EnergyTerm*>& terms, bool driven) {
  const Stage& stage = planned.stage;
  Trial trial;
  trial.velocities = planned.guess_velocities;
  trial.angular = planned.guess_angular;
  boundary.impose(stage, state.rotations, trial);
  // Where the step starts; of stages whose base lies elsewhere, too.
  Trial start = trial;
  start.velocities = (state.positions - stage.base_positions) / stage.beta;
  start.angular.setZero();
  update_trial(stage, start);
  const auto limit_of = [&](const Trial& to) {
    const Points change = stage.beta * (to.velocities - start.velocities);
    double limit = 1.0;
    for (const EnergyTerm* term : terms)
      limit = std::min(limit, term->step_limit(start, change));
    return limit;
  };
  double limit = limit_of(trial);
  // Drives are not shortened, so what is left has to be asked for again.
  for (int pass = 0; limit < 1.0 && pass < PASSES; ++pass) {
    trial.velocities = start.velocities + limit * (trial.velocities - start.velocities);
    if (!driven) {
      limit = 1.0;
      break;
    }
    boundary.impose(stage, state.rotations, trial);
    limit = limit_of(trial);
  }
  update_trial(stage, trial);
  if (limit >= 1.0 && is_finite(stage, trial, terms))
    return {trial, {}};
  Trial still = start;
  boundary.impose(stage, state.rotations, still);
  update_trial(stage, still);
  if (!driven || (limit_of(still) >= 1.0 && is_finite(stage, still, terms)))
    return {still, {}};
  return {start, still};
}

} // namespace wry::fem
