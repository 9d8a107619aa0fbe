#pragma once

namespace wry::mpm {

/// How a semi-implicit step is made (spec S6): (M + b dt^2 K)(v' - v) = dt f - d b dt^2 K v, K the elastic stiffness
/// frozen at the step's start. Waves of any speed are stable from b = 1/4 (d = 0) or 1/2 (d = 1) on. With d = 1 what
/// oscillates faster than the step resolves is damped away; with d = 0 it swings more slowly than it would, and a fibre
/// that is pulled stretches by dt v before it answers.
struct SemiImplicit {
  double courant = 4.0;      ///< how many cells the fastest wave may cross in a step
  double implicitness = 1.0; ///< b
  double damping = 1.0;      ///< d: 1 is the backward Euler step, 0 keeps the energy of slow waves
  double tolerance = 1e-2;   ///< the residual that is left, over the first one
};

} // namespace wry::mpm
