#include "sim/fem/terms/barrier.h"

#include <cmath>
#include <limits>

namespace wry::fem {

Barrier evaluate_barrier(double distance, double activation_distance, double stiffness) {
  if (distance >= activation_distance)
    return {};
  if (!(distance > 0.0))
    return {std::numeric_limits<double>::infinity(), 0.0, 0.0};
  const double gap = distance - activation_distance;
  const double logarithm = std::log(distance / activation_distance);
  const double ratio = gap / distance;
  return {-stiffness * gap * gap * logarithm, -stiffness * (2.0 * gap * logarithm + gap * ratio),
          -stiffness * (2.0 * logarithm + 4.0 * ratio - ratio * ratio)};
}

SmoothedSlip evaluate_slip(double slip, double smoothing) {
  if (slip >= smoothing)
    return {slip, 1.0 / slip, 0.0};
  const double ratio = slip / smoothing;
  return {smoothing * (ratio * ratio - ratio * ratio * ratio / 3.0 + 1.0 / 3.0), (2.0 - ratio) / smoothing,
          2.0 * (1.0 - ratio) / smoothing};
}

} // namespace wry::fem
