#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "sim/base/types.h"
#include "sim/contact/ccd.h"

namespace wry::contact {

/// The places of a pair.
inline PairPoints gather(const Points& x, const std::array<std::int32_t, 4>& nodes) {
  PairPoints points;
  for (int k = 0; k < 4; ++k)
    points.row(k) = x.row(nodes[static_cast<std::size_t>(k)]);
  return points;
}

/// The squared distance of the boxes around a pair's primitives [m^2]: theirs, from below, for a small part of the
/// time.
inline double squared_box_distance(PairKind kind, const Points& x, const std::array<std::int32_t, 4>& nodes) {
  double sum = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double a = x(nodes[0], i);
    const double b = x(nodes[1], i);
    const double c = x(nodes[2], i);
    const double d = x(nodes[3], i);
    double gap = 0.0;
    if (kind == PairKind::edge_edge)
      gap = std::max(std::min(a, b) - std::max(c, d), std::min(c, d) - std::max(a, b));
    else
      gap = std::max(a - std::max(std::max(b, c), d), std::min(std::min(b, c), d) - a);
    if (gap > 0.0)
      sum += gap * gap;
  }
  return sum;
}

} // namespace wry::contact
