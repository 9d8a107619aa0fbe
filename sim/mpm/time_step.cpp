#include "sim/mpm/time_step.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace wry::mpm {

std::string_view step_limit_name(StepLimit limit) {
  switch (limit) {
  case StepLimit::wave:
    return "wave speed";
  case StepLimit::speed:
    return "speed";
  case StepLimit::gradient:
    return "velocity gradient";
  case StepLimit::given:
    return "given";
  case StepLimit::frame:
    return "frame";
  }
  return "?";
}

namespace {

/// dt (speed + |g| dt) = length, so that matter at rest cannot outrun the bound as it begins to fall.
double time_to_cross(double length, double speed, double gravity) {
  const double root = speed + std::sqrt(speed * speed + 4.0 * gravity * length);
  return root > 0.0 ? 2.0 * length / root : std::numeric_limits<double>::max();
}

} // namespace

StepBound stable_step(const StepFacts& facts) {
  const double length = facts.courant * facts.cell;
  StepBound bound;
  if (facts.wave_courant) {
    bound = {time_to_cross(length, facts.speed, facts.gravity), StepLimit::speed};
    if (facts.sound_speed * bound.dt > *facts.wave_courant * facts.cell)
      bound = {*facts.wave_courant * facts.cell / facts.sound_speed, StepLimit::wave};
  } else {
    bound.dt = time_to_cross(length, facts.sound_speed + facts.speed, facts.gravity);
    bound.limit = facts.speed > facts.sound_speed ? StepLimit::speed : StepLimit::wave;
  }
  if (facts.gradient * bound.dt > facts.max_deformation)
    bound = {facts.max_deformation / facts.gradient, StepLimit::gradient};
  return bound;
}

ChosenStep choose_step(const StepBound& bound, std::optional<double> given, double time, double end) {
  ChosenStep step{bound.dt, bound.limit, false, 0.0};
  if (given) {
    step.given_over_stable = *given / bound.dt;
    if (*given <= bound.dt)
      step = {*given, StepLimit::given, false, step.given_over_stable};
  }
  const double left = end - time;
  // A step given by hand to 12 digits still fits in a whole number.
  const double parts = std::ceil(left / step.dt * (1.0 - 1e-12));
  if (parts <= 1.0)
    return {left, left < step.dt * (1.0 - 1e-9) ? StepLimit::frame : step.limit, true, step.given_over_stable};
  step.dt = left / parts;
  return step;
}

} // namespace wry::mpm
