#include "pipeline/measure/crossing_measures.h"

#include <algorithm>
#include <limits>

#include "sim/base/parallel.h"
#include "sim/contact/crossings.h"

namespace wry::pipeline {

SolidSurfaces solid_surfaces(const SceneStatic& scene) {
  SolidSurfaces solids;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    if (body.tets.rows() == 0)
      continue;
    std::vector<contact::Surface::Triangle> triangles;
    for (Eigen::Index t = 0; t < body.triangles.rows(); ++t)
      triangles.push_back({body.triangles(t, 0), body.triangles(t, 1), body.triangles(t, 2)});
    solids.surface.add_part(static_cast<int>(body.rest_positions.rows()), triangles);
    solids.bodies.push_back(i);
  }
  return solids;
}

Points SolidSurfaces::positions_in(const Frame& frame) const {
  Points positions(surface.node_count(), 3);
  Eigen::Index row = 0;
  for (const std::size_t index : bodies) {
    const Channel* channel = index < frame.bodies.size() ? find_channel(frame.bodies[index], "position") : nullptr;
    const Eigen::Index rows = channel != nullptr ? static_cast<Eigen::Index>(channel->values.size() / 3) : 0;
    if (rows == 0 || row + rows > positions.rows())
      return {};
    positions.middleRows(row, rows) = Eigen::Map<const Points>(channel->values.data(), rows, 3);
    row += rows;
  }
  return positions;
}

double crossings(const MeasurePlan& plan, const SceneStatic& scene, const Frame& frame) {
  SolidSurfaces solids = solid_surfaces(scene);
  const auto found = std::find(solids.bodies.begin(), solids.bodies.end(), plan.body);
  const Points positions = solids.positions_in(frame);
  if (found == solids.bodies.end() || positions.rows() == 0)
    return std::numeric_limits<double>::quiet_NaN();
  const int part = static_cast<int>(found - solids.bodies.begin());
  for (int other = 0; other < solids.surface.part_count(); ++other)
    solids.surface.let_meet(part, other);
  const std::vector<contact::Crossing> all =
      contact::find_crossings(solids.surface, positions, Threads(1), std::numeric_limits<std::size_t>::max());
  if (plan.nodes.empty())
    return static_cast<double>(all.size());
  std::size_t first_node = 0;
  for (auto before = solids.bodies.begin(); before != found; ++before)
    first_node += static_cast<std::size_t>(scene.bodies[*before].rest_positions.rows());
  std::vector<char> picked(static_cast<std::size_t>(positions.rows()), 0);
  for (const std::int32_t node : plan.nodes)
    picked[first_node + static_cast<std::size_t>(node)] = 1;
  const auto is_picked = [&](std::int32_t node) { return picked[static_cast<std::size_t>(node)] != 0; };
  return static_cast<double>(std::count_if(all.begin(), all.end(), [&](const contact::Crossing& crossing) {
    return std::any_of(crossing.edge.begin(), crossing.edge.end(), is_picked) ||
           std::any_of(crossing.triangle.begin(), crossing.triangle.end(), is_picked);
  }));
}

} // namespace wry::pipeline
