#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>

#include "sim/base/types.h"

namespace wry::scene {

/// Lower bounds of a distance, one per cube of space, worked out when a cube is first asked for and kept: most queries
/// want to know only that nothing is near, and one load answers them. Queries may run on many threads; what they get
/// does not depend on who came first.
class DistanceBounds {
public:
  /// Of a cube around `centre`: at most the distance at every point no further than `radius` [m] from it.
  using Bound = std::function<double(const Vec3& centre, double radius)>;

  /// Cubes of `side` [m], or as much more as keeps their number bounded, over a box; 4 bytes each.
  DistanceBounds(const Vec3& low, const Vec3& high, double side, Bound bound);

  /// [m]; minus infinity outside the box.
  double at(const Vec3& point) const;

private:
  Vec3 m_low;
  double m_side = 0.0;
  std::int64_t m_counts[3] = {0, 0, 0};
  Bound m_bound;
  mutable std::unique_ptr<std::atomic<float>[]> m_values; ///< NaN: not asked for yet
};

} // namespace wry::scene
