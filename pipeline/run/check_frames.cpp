#include "pipeline/run/check_frames.h"

#include "pipeline/cache/frame_cache.h"
#include "sim/contact/crossings.h"

namespace wry::pipeline {

namespace {

/// The solids of a scene: bodies with tets.
std::vector<std::size_t> solids_of(const SceneStatic& scene) {
  std::vector<std::size_t> solids;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].tets.rows() > 0)
      solids.push_back(i);
  }
  return solids;
}

contact::Surface surface_of(const SceneStatic& scene, const std::vector<std::size_t>& solids,
                            const shots::ContactOptions& contact) {
  contact::Surface surface;
  for (const std::size_t index : solids) {
    const SceneBody& body = scene.bodies[index];
    std::vector<contact::Surface::Triangle> triangles;
    for (Eigen::Index t = 0; t < body.triangles.rows(); ++t)
      triangles.push_back({body.triangles(t, 0), body.triangles(t, 1), body.triangles(t, 2)});
    const int part = surface.add_part(static_cast<int>(body.rest_positions.rows()), triangles);
    for (int other = 0; other <= part; ++other) {
      if (other == part ? *contact.within : *contact.between)
        surface.let_meet(part, other);
    }
  }
  return surface;
}

/// Positions of all solids, one after the other; empty when a frame lacks a body.
Points positions_of(const Frame& frame, const std::vector<std::size_t>& solids, int node_count) {
  Points positions(node_count, 3);
  Eigen::Index row = 0;
  for (const std::size_t index : solids) {
    const Channel* channel = index < frame.bodies.size() ? find_channel(frame.bodies[index], "position") : nullptr;
    const Eigen::Index rows = channel != nullptr ? static_cast<Eigen::Index>(channel->values.size() / 3) : 0;
    if (rows == 0 || row + rows > node_count)
      return {};
    positions.middleRows(row, rows) = Eigen::Map<const Points>(channel->values.data(), rows, 3);
    row += rows;
  }
  return positions;
}

} // namespace

Result<IntersectionReport> find_intersections(const shots::Shot& shot, const std::filesystem::path& out,
                                              const Threads& threads) {
  IntersectionReport report;
  if (!shot.contact)
    return report;
  const Result<FrameCache> cache = FrameCache::open_to_read(out / "frames");
  if (!cache)
    return cache.error();
  const Result<SceneStatic> scene = cache->read_static();
  if (!scene)
    return scene.error();
  const std::vector<std::size_t> solids = solids_of(*scene);
  const contact::Surface surface = surface_of(*scene, solids, *shot.contact);
  for (const CachedFrame& cached : cache->frames()) {
    const Result<Frame> frame = cache->read_frame(cached.number);
    if (!frame)
      return frame.error();
    const Points positions = positions_of(*frame, solids, surface.node_count());
    if (positions.rows() == 0)
      return make_error(ErrorCode::io, "frame {}: a solid has no positions", cached.number);
    ++report.frames;
    const std::vector<contact::Crossing> found = contact::find_crossings(surface, positions, threads);
    if (found.empty())
      continue;
    const contact::Crossing& first = found.front();
    const Vec3 at = 0.5 * (positions.row(first.edge[0]) + positions.row(first.edge[1]));
    const auto name = [&](std::int32_t node) {
      return scene->bodies[solids[static_cast<std::size_t>(surface.part_of_node(node))]].name;
    };
    report.findings.push_back(fmt::format("frame {}: {} edges cut triangles, the first of body '{}' and body '{}' near "
                                          "({:.6g}, {:.6g}, {:.6g})",
                                          cached.number, found.size(), name(first.edge[0]), name(first.triangle[0]),
                                          at.x(), at.y(), at.z()));
  }
  return report;
}

} // namespace wry::pipeline
