#include "sim/geometry/signed_distance_volume.h"

#include <algorithm>
#include <cmath>

namespace wry::geometry {

namespace {

struct Integral {
  const DistanceFunction& distance;
  double low, high, cell;

  /// Share of a cell below a level, from the distance at its middle; unbiased over all positions of a plane.
  static double share_below(double distance, double level, double size) {
    return std::clamp(0.5 + (level - distance) / size, 0.0, 1.0);
  }

  double over(const Vec3& centre, double size) const {
    const double value = distance(centre);
    const double reach = size * std::sqrt(3.0) / 2;
    const bool clear = std::abs(value - low) > reach && std::abs(value - high) > reach;
    if (clear || size <= cell)
      return (share_below(value, high, size) - share_below(value, low, size)) * size * size * size;
    double sum = 0;
    for (int octant = 0; octant < 8; ++octant)
      sum += over(centre + size / 4 * Vec3(octant & 1 ? 1 : -1, octant & 2 ? 1 : -1, octant & 4 ? 1 : -1), size / 2);
    return sum;
  }
};

} // namespace

double volume_between(const DistanceFunction& distance, const Bounds& bounds, double low, double high, double cell) {
  const Vec3 centre = (bounds.low + bounds.high) / 2;
  const double size = (bounds.high - bounds.low).maxCoeff();
  // The root is a power of two times the cell, so that leaves are exactly as wide as asked.
  const double root = cell * std::exp2(std::ceil(std::log2(std::max(1.0, size / cell))));
  return Integral{distance, low, high, cell}.over(centre, root);
}

} // namespace wry::geometry
