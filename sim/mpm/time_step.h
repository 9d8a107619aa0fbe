#pragma once

#include <optional>
#include <string_view>

namespace wry::mpm {

/// What bounds a step.
enum class StepLimit {
  wave,     ///< kappa h / (c + |v|), mostly by the wave speed c
  speed,    ///< the same, mostly by the speed
  gradient, ///< dt |L|
  given,    ///< by hand
  frame,    ///< a frame's time
};

std::string_view step_limit_name(StepLimit limit);

struct StepBound {
  double dt = 0.0; ///< [s]
  StepLimit limit = StepLimit::wave;
};

/// What a bound depends on.
struct StepFacts {
  double cell = 0.0;                  ///< h [m]
  double courant = 0.4;               ///< kappa
  std::optional<double> wave_courant; ///< of waves, where the step is implicit in them
  double max_deformation = 0.3;
  double sound_speed = 0.0; ///< c, the greatest of the materials as they are [m/s]
  double speed = 0.0;       ///< the greatest of particles and obstacles [m/s]
  double gravity = 0.0;     ///< |g| [m/s^2]
  double gradient = 0.0;    ///< the greatest |L| [1/s]
};

/// The longest stable step.
StepBound stable_step(const StepFacts& facts);

/// The step to take towards `end`: at most the bound and the one given by hand, of equal parts of what is left.
struct ChosenStep {
  double dt = 0.0;
  StepLimit limit = StepLimit::frame;
  bool lands = false;             ///< it ends at `end`
  double given_over_stable = 0.0; ///< 0: none given
};
ChosenStep choose_step(const StepBound& bound, std::optional<double> given, double time, double end);

} // namespace wry::mpm
