#include "sim/fem/terms/slip.h"

namespace wry::fem {

SmoothedSlip evaluate_slip(double slip, double smoothing) {
  if (slip >= smoothing)
    return {slip, 1.0 / slip, 0.0};
  const double ratio = slip / smoothing;
  return {smoothing * (ratio * ratio - ratio * ratio * ratio / 3.0 + 1.0 / 3.0), (2.0 - ratio) / smoothing,
          2.0 * (1.0 - ratio) / smoothing};
}

Mat3 slip_hessian(const Vec3& slip, const Vec3& normal, double smoothing, SlipHessian kind) {
  const double length = slip.norm();
  const SmoothedSlip smoothed = evaluate_slip(length, smoothing);
  Mat3 block = smoothed.slope_over_slip * (Mat3::Identity() - normal * normal.transpose());
  if (length > 0.0 && kind == SlipHessian::exact) {
    const Vec3 along = slip / length;
    block += (smoothed.second - smoothed.slope_over_slip) * (along * along.transpose());
  }
  return block;
}

} // namespace wry::fem
