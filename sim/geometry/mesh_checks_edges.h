#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "sim/base/types.h"

namespace wry::geometry {

/// One side of a triangle; sorted by (low, high, triangle), the sides of one edge are neighbours.
struct TriangleSide {
  std::int32_t low;  ///< vertex
  std::int32_t high; ///< vertex
  std::int32_t triangle;
  std::int32_t corner; ///< the side starts at this corner of the triangle
  bool forward;        ///< runs from low to high
};

/// Sides of all triangles with `use[triangle]`, sorted.
std::vector<TriangleSide> sorted_sides(const Triangles& triangles, const std::vector<char>& use);

/// Calls edge(first, last) for the sides of each edge, as a range of indices.
void for_each_edge(const std::vector<TriangleSide>& sides, const std::function<void(std::size_t, std::size_t)>& edge);

/// Triangles whose indices are in range and differ.
std::vector<char> usable_triangles(const Triangles& triangles, Eigen::Index vertices);

/// Disjoint sets; the representative of a set is its lowest member.
class DisjointSets {
public:
  explicit DisjointSets(std::size_t count);
  std::int32_t find(std::int32_t member);
  void join(std::int32_t a, std::int32_t b);

private:
  std::vector<std::int32_t> m_parent;
};

} // namespace wry::geometry
