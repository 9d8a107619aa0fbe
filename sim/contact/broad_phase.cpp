#include "sim/contact/broad_phase.h"

#include <algorithm>

namespace wry::contact {

namespace {

constexpr std::size_t GRAIN = 128;

bool share_node(const Surface::Edge& a, const Surface::Edge& b) {
  return a[0] == b[0] || a[0] == b[1] || a[1] == b[0] || a[1] == b[1];
}

bool has_node(const Surface::Triangle& triangle, std::int32_t node) {
  return triangle[0] == node || triangle[1] == node || triangle[2] == node;
}

} // namespace

bool BroadPhase::holds(const Points& positions) const {
  for (const std::int32_t node : m_surface.points()) {
    const double* x = positions.data() + 3 * static_cast<std::ptrdiff_t>(node);
    const Box& room = m_rooms[node];
    for (int i = 0; i < 3; ++i) {
      if (!(x[i] >= room.low[i] && x[i] <= room.high[i]))
        return false;
    }
  }
  return true;
}

bool BroadPhase::cover(const Points& from, const Points& to, double distance, double margin) {
  if (m_valid && distance <= m_distance && holds(from) && holds(to))
    return true;
  m_rooms.resize(static_cast<std::size_t>(m_surface.node_count()));
  for (const std::int32_t node : m_surface.points()) {
    Box& room = m_rooms[node];
    for (int i = 0; i < 3; ++i) {
      const double a = from(node, i);
      const double b = to(node, i);
      // Those that move fast change their way by more.
      const double spare = margin + 0.1 * std::abs(b - a);
      room.low[i] = std::min(a, b) - spare;
      room.high[i] = std::max(a, b) + spare;
    }
  }
  m_distance = distance;
  m_valid = search(distance);
  if (!m_valid) {
    m_point_triangles.clear();
    m_edge_edges.clear();
  }
  return m_valid;
}

template <class Find>
bool BroadPhase::collect(std::size_t count, std::vector<CandidatePair>& out, std::size_t room, const Find& find) {
  m_chunks.resize(std::max(m_chunks.size(), (count + GRAIN - 1) / GRAIN));
  m_threads.for_chunks(count, GRAIN, [&](std::size_t begin, std::size_t end) {
    std::vector<CandidatePair>& chunk = m_chunks[begin / GRAIN];
    chunk.clear();
    for (std::size_t i = begin; i < end && chunk.size() <= room; ++i) {
      const auto before = static_cast<std::ptrdiff_t>(chunk.size());
      find(static_cast<std::int32_t>(i), chunk);
      // The tree's order depends on when it was built; sums over pairs must not.
      std::sort(chunk.begin() + before, chunk.end(),
                [](const CandidatePair& a, const CandidatePair& b) { return a.second < b.second; });
    }
  });
  out.clear();
  for (std::size_t index = 0; index < (count + GRAIN - 1) / GRAIN; ++index) {
    const std::vector<CandidatePair>& chunk = m_chunks[index];
    if (out.size() + chunk.size() > room)
      return false;
    out.insert(out.end(), chunk.begin(), chunk.end());
  }
  return true;
}

bool BroadPhase::search(double distance) {
  ++m_searches;
  const std::vector<Surface::Triangle>& triangles = m_surface.triangles();
  const std::vector<Surface::Edge>& edges = m_surface.edges();
  const std::vector<std::int32_t>& points = m_surface.points();
  m_triangle_boxes.resize(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    m_triangle_boxes[i] = m_rooms[triangles[i][0]];
    m_triangle_boxes[i].include(m_rooms[triangles[i][1]]);
    m_triangle_boxes[i].include(m_rooms[triangles[i][2]]);
  }
  m_edge_boxes.resize(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    m_edge_boxes[i] = m_rooms[edges[i][0]];
    m_edge_boxes[i].include(m_rooms[edges[i][1]]);
  }
  m_triangle_tree.build(m_triangle_boxes);
  m_edge_tree.build(m_edge_boxes);
  const bool fits =
      collect(points.size(), m_point_triangles, m_most_pairs, [&](std::int32_t i, std::vector<CandidatePair>& out) {
        Box box = m_rooms[points[i]];
        box.grow(distance);
        const int part = m_surface.part_of_node(points[i]);
        m_triangle_tree.query(box, [&](std::int32_t j) {
          const Surface::Triangle& t = triangles[j];
          if (m_surface.meet(part, m_surface.part_of_node(t[0])) && !has_node(t, points[i]))
            out.push_back({{points[i], t[0], t[1], t[2]}, i, j});
        });
      });
  return fits && collect(edges.size(), m_edge_edges, m_most_pairs - m_point_triangles.size(),
                         [&](std::int32_t i, std::vector<CandidatePair>& out) {
                           Box box = m_edge_boxes[i];
                           box.grow(distance);
                           const Surface::Edge& e = edges[i];
                           const int part = m_surface.part_of_node(e[0]);
                           m_edge_tree.query(box, [&](std::int32_t j) {
                             const Surface::Edge& f = edges[j];
                             if (j > i && m_surface.meet(part, m_surface.part_of_node(f[0])) && !share_node(e, f))
                               out.push_back({{e[0], e[1], f[0], f[1]}, i, j});
                           });
                         });
}

std::size_t BroadPhase::memory_bytes() const {
  std::size_t bytes = (m_point_triangles.capacity() + m_edge_edges.capacity()) * sizeof(CandidatePair);
  for (const std::vector<CandidatePair>& chunk : m_chunks)
    bytes += chunk.capacity() * sizeof(CandidatePair);
  return bytes + (m_rooms.capacity() + 2 * (m_triangle_boxes.capacity() + m_edge_boxes.capacity())) * sizeof(Box);
}

std::vector<CandidatePair> all_pairs(const Surface& surface, PairKind kind) {
  std::vector<CandidatePair> pairs;
  const auto& edges = surface.edges();
  const auto& triangles = surface.triangles();
  const auto& points = surface.points();
  if (kind == PairKind::edge_edge) {
    for (std::size_t i = 0; i < edges.size(); ++i) {
      for (std::size_t j = i + 1; j < edges.size(); ++j) {
        if (surface.meet(surface.part_of_node(edges[i][0]), surface.part_of_node(edges[j][0])) &&
            !share_node(edges[i], edges[j]))
          pairs.push_back({{edges[i][0], edges[i][1], edges[j][0], edges[j][1]},
                           static_cast<std::int32_t>(i),
                           static_cast<std::int32_t>(j)});
      }
    }
    return pairs;
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < triangles.size(); ++j) {
      const Surface::Triangle& t = triangles[j];
      if (surface.meet(surface.part_of_node(points[i]), surface.part_of_node(t[0])) && !has_node(t, points[i]))
        pairs.push_back({{points[i], t[0], t[1], t[2]}, static_cast<std::int32_t>(i), static_cast<std::int32_t>(j)});
    }
  }
  return pairs;
}

} // namespace wry::contact
