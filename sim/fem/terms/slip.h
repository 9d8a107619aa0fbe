#pragma once

#include "sim/base/types.h"

namespace wry::fem {

/// Smoothed friction: f0 of the slip y and h = friction velocity x dt (spec §5).
struct SmoothedSlip {
  double value = 0.0;           ///< f0 [m]
  double slope_over_slip = 0.0; ///< f0' / y [1/m], finite at y = 0
  double second = 0.0;          ///< f0'' [1/m]
};
SmoothedSlip evaluate_slip(double slip, double smoothing);

/// How friction's second derivative is taken.
enum class SlipHessian {
  exact,
  bounded, ///< along the slip as steep as across it: from above
};

/// Second derivative of f0(|slip|) by the place that slips in the plane across `normal` [1/m].
Mat3 slip_hessian(const Vec3& slip, const Vec3& normal, double smoothing, SlipHessian kind);

} // namespace wry::fem
