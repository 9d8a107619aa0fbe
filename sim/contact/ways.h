#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "sim/contact/ccd.h"
#include "sim/contact/surface.h"

namespace wry::contact {

/// How far each node has come, relative to the middle of its part where that is asked for: in single precision, since
/// it serves the quick answer that most pairs are as far apart as they were. What rounding does is on the safe side.
class Ways {
public:
  /// `since_middles`, `now_middles`: parts x 3, taken off; as in BroadPhase.
  void measure(const Surface& surface, const Points& since, const Points& since_middles, const Points& now,
               const Points& now_middles);

  /// Whether the points of a pair have come nearer to each other by less than this [m].
  bool are_below(PairKind kind, const std::array<std::int32_t, 4>& nodes, double limit) const {
    const float least = static_cast<float>(limit) * (1.0F - 1e-6F) - m_rounding;
    if (!(least > 0.0F))
      return false;
    const float squared = least * least;
    const Eigen::Array4f& a = m_ways[static_cast<std::size_t>(nodes[0])];
    const Eigen::Array4f& b = m_ways[static_cast<std::size_t>(nodes[1])];
    const Eigen::Array4f& c = m_ways[static_cast<std::size_t>(nodes[2])];
    const Eigen::Array4f& d = m_ways[static_cast<std::size_t>(nodes[3])];
    const auto near = [squared](const Eigen::Array4f& p, const Eigen::Array4f& q) {
      return (p - q).square().sum() < squared;
    };
    if (kind == PairKind::edge_edge)
      return near(a, c) && near(a, d) && near(b, c) && near(b, d);
    return near(a, b) && near(a, c) && near(a, d);
  }

private:
  std::vector<Eigen::Array4f> m_ways;
  float m_rounding = 0.0F;
};

} // namespace wry::contact
