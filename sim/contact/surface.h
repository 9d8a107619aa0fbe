#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/base/types.h"

namespace wry::contact {

/// Everything that may touch: the surfaces of bodies and obstacles over one numbering of nodes. A part is a body or an
/// obstacle.
class Surface {
public:
  using Edge = std::array<std::int32_t, 2>;
  using Triangle = std::array<std::int32_t, 3>;

  /// Adds a part whose nodes follow those that are there. Indices are relative to its first node. Its points are the
  /// nodes that triangles, edges and `loose_points` use; its edges those of the triangles and `loose_edges`.
  /// Returns the part's number.
  int add_part(int node_count, const std::vector<Triangle>& triangles, const std::vector<Edge>& loose_edges = {},
               const std::vector<std::int32_t>& loose_points = {});
  /// Lets two parts (or, for a == b, one part and itself) touch. At first nothing may.
  void let_meet(int a, int b);

  bool meet(int part, int other) const { return m_meet[static_cast<std::size_t>(part) * m_row + other] != 0; }
  int part_count() const { return m_part_count; }
  int node_count() const { return static_cast<int>(m_part_of_node.size()); }
  int part_of_node(int node) const { return m_part_of_node[node]; }

  const std::vector<std::int32_t>& points() const { return m_points; }
  const std::vector<Edge>& edges() const { return m_edges; }
  const std::vector<Triangle>& triangles() const { return m_triangles; }

private:
  std::size_t m_row = 0; ///< length of a row of m_meet
  int m_part_count = 0;
  std::vector<char> m_meet;
  std::vector<std::int32_t> m_part_of_node;
  std::vector<std::int32_t> m_points;
  std::vector<Edge> m_edges;
  std::vector<Triangle> m_triangles;
};

} // namespace wry::contact
