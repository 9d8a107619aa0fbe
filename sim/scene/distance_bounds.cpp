#include "sim/scene/distance_bounds.h"

#include <cmath>
#include <limits>

namespace wry::scene {

DistanceBounds::DistanceBounds(const Cubes& cubes, double slope, Distance distance)
    : m_cubes(cubes)
    , m_slope(slope)
    , m_distance(std::move(distance)) {
  const auto count = static_cast<std::size_t>(cubes.count());
  m_values = std::make_unique<std::atomic<float>[]>(count);
  for (std::size_t i = 0; i < count; ++i)
    m_values[i].store(std::numeric_limits<float>::quiet_NaN(), std::memory_order_relaxed);
}

DistanceBounds::Bracket DistanceBounds::around(const Vec3& point) const {
  const Cubes::Place place = m_cubes.find(point);
  if (place.cube < 0)
    return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  std::atomic<float>& value = m_values[static_cast<std::size_t>(place.cube)];
  float distance = value.load(std::memory_order_relaxed);
  if (std::isnan(distance)) {
    distance = static_cast<float>(m_distance(place.centre));
    value.store(distance, std::memory_order_relaxed);
  }
  constexpr double ROUNDING = 2e-7; // of a float, and of where the centre is
  const auto middle = static_cast<double>(distance);
  const double change = m_slope * (point - place.centre).norm() + ROUNDING * (std::abs(middle) + m_cubes.side());
  return {middle - change, middle + change};
}

} // namespace wry::scene
