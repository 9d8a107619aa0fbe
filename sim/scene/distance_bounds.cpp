#include "sim/scene/distance_bounds.h"

#include <cmath>
#include <limits>

namespace wry::scene {

DistanceBounds::DistanceBounds(const Vec3& low, const Vec3& high, double side, Bound bound)
    : m_low(low)
    , m_side(side)
    , m_bound(std::move(bound)) {
  constexpr double MOST_CUBES = 4e6;
  const Vec3 size = (high - low).cwiseMax(side);
  const double cubes = (size / side).array().ceil().prod();
  if (cubes > MOST_CUBES)
    m_side *= std::cbrt(cubes / MOST_CUBES) * 1.1;
  std::int64_t total = 1;
  for (int axis = 0; axis < 3; ++axis) {
    m_counts[axis] = static_cast<std::int64_t>(std::ceil(size[axis] / m_side));
    total *= m_counts[axis];
  }
  m_values = std::make_unique<std::atomic<float>[]>(static_cast<std::size_t>(total));
  for (std::int64_t i = 0; i < total; ++i)
    m_values[static_cast<std::size_t>(i)].store(std::numeric_limits<float>::quiet_NaN(), std::memory_order_relaxed);
}

double DistanceBounds::at(const Vec3& point) const {
  std::int64_t index = 0;
  Vec3 centre;
  for (int axis = 0; axis < 3; ++axis) {
    const double cell = std::floor((point[axis] - m_low[axis]) / m_side);
    if (!(cell >= 0.0 && cell < static_cast<double>(m_counts[axis])))
      return -std::numeric_limits<double>::infinity();
    index = index * m_counts[axis] + static_cast<std::int64_t>(cell);
    centre[axis] = m_low[axis] + (cell + 0.5) * m_side;
  }
  std::atomic<float>& value = m_values[static_cast<std::size_t>(index)];
  float bound = value.load(std::memory_order_relaxed);
  if (std::isnan(bound)) {
    constexpr double ROUNDING = 1.0 + 1e-9;
    const double found = m_bound(centre, 0.5 * std::sqrt(3.0) * m_side * ROUNDING);
    bound = std::nextafterf(static_cast<float>(found), -std::numeric_limits<float>::infinity());
    value.store(bound, std::memory_order_relaxed);
  }
  return static_cast<double>(bound);
}

} // namespace wry::scene
