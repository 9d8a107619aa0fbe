#pragma once

#include <atomic>
#include <functional>
#include <memory>

#include "sim/scene/cubes.h"

namespace wry::scene {

/// Bounds of a distance from its values at the centres of cubes of space, which are worked out when a cube is first
/// asked for and kept: most queries want to know only that nothing is near, and one load answers them. Queries may run
/// on many threads; what they get does not depend on who came first.
class DistanceBounds {
public:
  using Distance = std::function<double(const Vec3& point)>;

  /// `slope` is the most by which the distance changes per metre. 4 bytes per cube.
  DistanceBounds(const Cubes& cubes, double slope, Distance distance);

  struct Bracket {
    double least, greatest; ///< [m]
  };
  /// What the distance at a point lies between; infinite outside the cubes.
  Bracket around(const Vec3& point) const;

private:
  Cubes m_cubes;
  double m_slope;
  Distance m_distance;
  mutable std::unique_ptr<std::atomic<float>[]> m_values; ///< NaN: not asked for yet
};

} // namespace wry::scene
