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

StepBound stable_step(const StepFacts& facts) {
  // dt (c + |v| + |g| dt) = kappa h, so that matter at rest cannot outrun the bound as it begins to fall.
  const double speed = facts.sound_speed + facts.speed;
  const double length = facts.courant * facts.cell;
  StepBound bound;
  const double root = speed + std::sqrt(speed * speed + 4.0 * facts.gravity * length);
  bound.dt = root > 0.0 ? 2.0 * length / root : std::numeric_limits<double>::max();
  bound.limit = facts.speed > facts.sound_speed ? StepLimit::speed : StepLimit::wave;
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
