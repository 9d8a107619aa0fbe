#include "pipeline/run/check_frames.h"

#include "pipeline/cache/frame_cache.h"
#include "pipeline/measure/crossing_measures.h"
#include "sim/contact/crossings.h"

namespace wry::pipeline {

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
  SolidSurfaces solids = solid_surfaces(*scene);
  contact::Surface& surface = solids.surface;
  for (int part = 0; part < surface.part_count(); ++part) {
    for (int other = 0; other <= part; ++other) {
      if (other == part ? *shot.contact->within : *shot.contact->between)
        surface.let_meet(part, other);
    }
  }
  for (const CachedFrame& cached : cache->frames()) {
    const Result<Frame> frame = cache->read_frame(cached.number);
    if (!frame)
      return frame.error();
    const Points positions = solids.positions_in(*frame);
    if (positions.rows() == 0)
      return make_error(ErrorCode::io, "frame {}: a solid has no positions", cached.number);
    ++report.frames;
    const std::vector<contact::Crossing> found = contact::find_crossings(surface, positions, threads);
    if (found.empty())
      continue;
    const contact::Crossing& first = found.front();
    const Vec3 at = 0.5 * (positions.row(first.edge[0]) + positions.row(first.edge[1]));
    const auto name = [&](std::int32_t node) {
      return scene->bodies[solids.bodies[static_cast<std::size_t>(surface.part_of_node(node))]].name;
    };
    report.findings.push_back(fmt::format("frame {}: {} edges cut triangles, the first of body '{}' and body '{}' near "
                                          "({:.6g}, {:.6g}, {:.6g})",
                                          cached.number, found.size(), name(first.edge[0]), name(first.triangle[0]),
                                          at.x(), at.y(), at.z()));
  }
  return report;
}

} // namespace wry::pipeline
