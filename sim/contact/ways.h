#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "sim/contact/ccd.h"
#include "sim/contact/moving_box.h"
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
    if (m_most == 0.0F) // as at the start of a step, from where the list was made
      return true;
    const auto way = [&](std::size_t k) -> const Eigen::Array4f& { return m_ways[static_cast<std::size_t>(nodes[k])]; };
    const bool edges = kind == PairKind::edge_edge;
    const Eigen::Array4f& other = way(edges ? 1 : 0); // of a point, its way to a third corner counts twice
    const Eigen::Array4f squares = squares_of(
        std::array<Eigen::Array4f, 4>{way(0) - way(2), way(0) - way(3), other - way(edges ? 2 : 1), other - way(3)});
    return all_below(squares, least * least);
  }

private:
  std::vector<Eigen::Array4f> m_ways;
  float m_most = 0.0F; ///< of a coordinate [m]
  float m_rounding = 0.0F;
};

} // namespace wry::contact
