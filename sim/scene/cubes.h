#pragma once

#include <cmath>
#include <cstdint>

#include "sim/base/types.h"

namespace wry::scene {

/// A box cut into cubes.
class Cubes {
public:
  /// Cubes of `side` [m], or as much more as keeps their number below four million.
  Cubes(const Vec3& low, const Vec3& high, double side)
      : m_low(low)
      , m_side(side) {
    constexpr double MOST = 4e6;
    const Vec3 size = (high - low).cwiseMax(side);
    const double wanted = (size / side).array().ceil().prod();
    if (wanted > MOST)
      m_side *= std::cbrt(wanted / MOST) * 1.1;
    m_per_side = 1.0 / m_side;
    for (int axis = 0; axis < 3; ++axis) {
      m_counts[axis] = std::ceil(size[axis] / m_side);
      m_bricks[axis] = (static_cast<std::uint64_t>(m_counts[axis]) + BRICK - 1) / BRICK;
    }
  }

  /// Numbers of cubes are less than this.
  std::int64_t count() const {
    return static_cast<std::int64_t>(m_bricks[0] * m_bricks[1] * m_bricks[2] * BRICK * BRICK * BRICK);
  }
  double side() const { return m_side; }
  /// Of the cube's corners from its centre, and a little more for rounding [m].
  double radius() const { return 0.8661 * m_side; }

  struct Place {
    std::int64_t cube = -1; ///< -1: outside the box
    Vec3 centre = Vec3::Zero();
  };
  Place find(const Vec3& point) const {
    Place place;
    std::uint64_t brick = 0, in_brick = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double along = std::floor((point[axis] - m_low[axis]) * m_per_side);
      if (!(along >= 0.0 && along < m_counts[axis]))
        return place;
      const auto cube = static_cast<std::uint64_t>(static_cast<std::int64_t>(along));
      brick = brick * m_bricks[axis] + cube / BRICK;
      in_brick = in_brick * BRICK + cube % BRICK;
      place.centre[axis] = m_low[axis] + (along + 0.5) * m_side;
    }
    place.cube = static_cast<std::int64_t>(brick * (BRICK * BRICK * BRICK) + in_brick);
    return place;
  }

private:
  Vec3 m_low;
  double m_side, m_per_side;
  /// Numbered brick by brick, so that what is near in space is near in memory.
  static constexpr std::uint64_t BRICK = 8;
  double m_counts[3];
  std::uint64_t m_bricks[3];
};

} // namespace wry::scene
