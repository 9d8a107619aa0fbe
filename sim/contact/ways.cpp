#include "sim/contact/ways.h"

#include <algorithm>
#include <cfloat>

namespace wry::contact {

void Ways::measure(const Surface& surface, const Points& since, const Points& since_middles, const Points& now,
                   const Points& now_middles) {
  m_ways.assign(static_cast<std::size_t>(surface.node_count()), Eigen::Array4f::Zero());
  const Points flown = now_middles - since_middles;
  m_most = 0.0F;
  for (const std::int32_t node : surface.points()) {
    const int part = surface.part_of_node(node);
    Eigen::Array4f& way = m_ways[static_cast<std::size_t>(node)];
    for (int i = 0; i < 3; ++i) {
      way[i] = static_cast<float>(now(node, i) - since(node, i) - flown(part, i));
      m_most = std::max(m_most, std::abs(way[i]));
    }
  }
  // Two roundings to single precision, a difference and a sum of three squares, each half a unit.
  m_rounding = 8.0F * FLT_EPSILON * m_most;
}

} // namespace wry::contact
