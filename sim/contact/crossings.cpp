#include "sim/contact/crossings.h"

#include "sim/contact/box_tree.h"
#include "sim/geometry/mesh_checks_predicates.h"

namespace wry::contact {

namespace {

constexpr std::size_t GRAIN = 256;

template <std::size_t N> Box box_of(const std::array<std::int32_t, N>& nodes, const Points& positions) {
  Box box;
  for (int i = 0; i < 3; ++i) {
    box.low[i] = box.high[i] = positions(nodes[0], i);
    for (std::size_t k = 1; k < N; ++k) {
      box.low[i] = std::min(box.low[i], positions(nodes[k], i));
      box.high[i] = std::max(box.high[i], positions(nodes[k], i));
    }
  }
  return box;
}

bool share_node(const Surface::Edge& edge, const Surface::Triangle& triangle) {
  for (const std::int32_t node : triangle) {
    if (node == edge[0] || node == edge[1])
      return true;
  }
  return false;
}

} // namespace

std::vector<Crossing> find_crossings(const Surface& surface, const Points& positions, const Threads& threads,
                                     std::size_t limit) {
  const std::vector<Surface::Triangle>& triangles = surface.triangles();
  const std::vector<Surface::Edge>& edges = surface.edges();
  std::vector<Box> boxes(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i)
    boxes[i] = box_of(triangles[i], positions);
  BoxTree tree;
  tree.build(boxes);
  std::vector<std::vector<Crossing>> chunks((edges.size() + GRAIN - 1) / GRAIN);
  threads.for_chunks(edges.size(), GRAIN, [&](std::size_t begin, std::size_t end) {
    std::vector<Crossing>& found = chunks[begin / GRAIN];
    for (std::size_t i = begin; i < end && found.size() < limit; ++i) {
      const Surface::Edge& edge = edges[i];
      const int part = surface.part_of_node(edge[0]);
      tree.query(box_of(edge, positions), [&](std::int32_t j) {
        const Surface::Triangle& t = triangles[j];
        if (!surface.meet(part, surface.part_of_node(t[0])) || share_node(edge, t))
          return;
        if (geometry::segment_meets_triangle(positions.row(edge[0]), positions.row(edge[1]), positions.row(t[0]),
                                             positions.row(t[1]), positions.row(t[2])))
          found.push_back({edge, t});
      });
    }
  });
  std::vector<Crossing> all;
  for (const std::vector<Crossing>& chunk : chunks) {
    for (const Crossing& crossing : chunk) {
      if (all.size() < limit)
        all.push_back(crossing);
    }
  }
  return all;
}

} // namespace wry::contact
