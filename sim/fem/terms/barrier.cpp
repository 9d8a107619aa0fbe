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

} // namespace wry::fem
