#pragma once

#include <array>
#include <cstdint>

namespace wry::geometry {

/// A triangular prism: columns 0, 1, 2 join top[i] to bottom[i]; the top is counter-clockwise seen from above, so that
/// a prism of positive volume has (top1-top0) x (top2-top0) . (top0-bottom0) > 0.
struct Prism {
  std::array<std::int32_t, 3> top;
  std::array<std::int32_t, 3> bottom;
};

/// Which diagonal a side has. Side i lies between columns i and (i+1) % 3.
enum class Diagonal : std::uint8_t {
  down, ///< from top[i] to bottom[(i+1) % 3]
  up,   ///< from bottom[i] to top[(i+1) % 3]
};

/// Whether these diagonals cut the prism into three tets; three that run around it do not.
inline bool is_splittable(const std::array<Diagonal, 3>& sides) {
  return !(sides[0] == sides[1] && sides[1] == sides[2]);
}

/// The three tets of a splittable choice, positively oriented if the prism is.
inline std::array<std::array<std::int32_t, 4>, 3> split_prism(const Prism& prism,
                                                              const std::array<Diagonal, 3>& sides) {
  // A diagonal from top i to bottom j puts column i before column j; an acyclic choice orders the three columns.
  std::array<int, 3> rank{};
  for (int i = 0; i < 3; ++i)
    ++rank[sides[i] == Diagonal::down ? (i + 1) % 3 : i];
  std::array<int, 3> column{};
  for (int i = 0; i < 3; ++i)
    column[rank[i]] = i;
  const auto& t = prism.top;
  const auto& b = prism.bottom;
  const auto [p, q, r] = column;
  std::array<std::array<std::int32_t, 4>, 3> tets{
      {{b[r], t[p], t[q], t[r]}, {b[q], b[r], t[p], t[q]}, {b[p], b[q], b[r], t[p]}}};
  const bool even = (q == (p + 1) % 3);
  if (!even) {
    for (auto& tet : tets)
      std::swap(tet[0], tet[1]);
  }
  return tets;
}

} // namespace wry::geometry
