#include "sim/geometry/mesh_checks_edges.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace wry::geometry {

std::vector<TriangleSide> sorted_sides(const Triangles& triangles, const std::vector<char>& use) {
  std::vector<TriangleSide> sides;
  sides.reserve(static_cast<std::size_t>(triangles.rows()) * 3);
  for (std::int32_t t = 0; t < triangles.rows(); ++t) {
    if (!use[t])
      continue;
    for (std::int32_t k = 0; k < 3; ++k) {
      const std::int32_t a = triangles(t, k);
      const std::int32_t b = triangles(t, (k + 1) % 3);
      sides.push_back({std::min(a, b), std::max(a, b), t, k, a < b});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const TriangleSide& a, const TriangleSide& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return sides;
}

void for_each_edge(const std::vector<TriangleSide>& sides, const std::function<void(std::size_t, std::size_t)>& edge) {
  for (std::size_t first = 0; first < sides.size();) {
    std::size_t last = first + 1;
    while (last < sides.size() && sides[last].low == sides[first].low && sides[last].high == sides[first].high)
      ++last;
    edge(first, last);
    first = last;
  }
}

std::vector<char> usable_triangles(const Triangles& triangles, Eigen::Index vertices) {
  std::vector<char> use(static_cast<std::size_t>(triangles.rows()), 0);
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const std::int32_t a = triangles(t, 0);
    const std::int32_t b = triangles(t, 1);
    const std::int32_t c = triangles(t, 2);
    const bool in_range = std::min({a, b, c}) >= 0 && std::max({a, b, c}) < vertices;
    use[static_cast<std::size_t>(t)] = in_range && a != b && b != c && c != a;
  }
  return use;
}

DisjointSets::DisjointSets(std::size_t count)
    : m_parent(count) {
  std::iota(m_parent.begin(), m_parent.end(), 0);
}

std::int32_t DisjointSets::find(std::int32_t member) {
  while (m_parent[member] != member) {
    m_parent[member] = m_parent[m_parent[member]];
    member = m_parent[member];
  }
  return member;
}

void DisjointSets::join(std::int32_t a, std::int32_t b) {
  a = find(a);
  b = find(b);
  m_parent[std::max(a, b)] = std::min(a, b);
}

} // namespace wry::geometry
