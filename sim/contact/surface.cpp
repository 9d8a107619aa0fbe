#include "sim/contact/surface.h"

#include <algorithm>

namespace wry::contact {

int Surface::add_part(int node_count, const std::vector<Triangle>& triangles, const std::vector<Edge>& loose_edges,
                      const std::vector<std::int32_t>& loose_points) {
  const std::int32_t first = this->node_count();
  std::vector<Edge> edges = loose_edges;
  std::vector<std::int32_t> points = loose_points;
  for (const Triangle& triangle : triangles) {
    m_triangles.push_back({triangle[0] + first, triangle[1] + first, triangle[2] + first});
    for (std::size_t k = 0; k < 3; ++k)
      edges.push_back({triangle[k], triangle[(k + 1) % 3]});
  }
  for (Edge& edge : edges) {
    std::sort(edge.begin(), edge.end());
    points.insert(points.end(), edge.begin(), edge.end());
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  for (const Edge& edge : edges)
    m_edges.push_back({edge[0] + first, edge[1] + first});
  for (const std::int32_t point : points)
    m_points.push_back(point + first);
  m_part_of_node.resize(static_cast<std::size_t>(first + node_count), m_part_count);
  std::vector<char> meet(static_cast<std::size_t>(m_part_count + 1) * static_cast<std::size_t>(m_part_count + 1), 0);
  for (std::size_t a = 0; a < m_row; ++a)
    std::copy_n(m_meet.begin() + static_cast<std::ptrdiff_t>(a * m_row), m_row,
                meet.begin() + static_cast<std::ptrdiff_t>(a * (m_row + 1)));
  m_meet = std::move(meet);
  ++m_row;
  return m_part_count++;
}

void Surface::let_meet(int a, int b) {
  m_meet[static_cast<std::size_t>(a) * m_row + static_cast<std::size_t>(b)] = 1;
  m_meet[static_cast<std::size_t>(b) * m_row + static_cast<std::size_t>(a)] = 1;
}

} // namespace wry::contact
