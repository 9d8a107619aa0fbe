#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/cache/frame_cache.h"
#include "sim/state/frame.h"

namespace wry::pipeline {

/// What is exported, and where to.
struct ExportJob {
  const FrameCache& cache;
  const SceneStatic& cached_scene;             ///< of the cache's frames
  const SceneStatic& scene;                    ///< as it is shown: artists' meshes in place of elements
  std::function<Frame(const Frame&)> as_shown; ///< a frame of the cache, for `scene`
  std::filesystem::path frames_folder;         ///< of the cache
  std::filesystem::path folder;                ///< exports/<format>, exists
  std::string name;                            ///< of the shot
  std::vector<int> frames;                     ///< ascending, all in the cache
  int first_frame = 1;                         ///< of the shot: time 0
  double fps = 24.0;
  char up = 'y'; ///< 'x', 'y' or 'z'
};

/// One format. A new one is a .cpp and a line in the table.
struct Exporter {
  std::string_view name; ///< as in --to
  std::string_view doc;
  /// Writes every file whole or not at all. Errors: bad_input for what the format cannot hold, naming the body; io,
  /// cannot_write, stopped; unavailable for a part that this build lacks.
  Status (*write)(const ExportJob&);
};

std::span<const Exporter> exporters();

Status export_ply(const ExportJob& job);
Status export_obj(const ExportJob& job);
Status export_vdb(const ExportJob& job);
Status export_usda(const ExportJob& job);
Status export_pc2(const ExportJob& job);
Status export_xdmf(const ExportJob& job);

/// Calls `use` with every frame of the job in order, as they are shown; stops at the first error, or when a stop was
/// asked for.
Status for_each_frame(const ExportJob& job, const std::function<Status(const Frame&)>& use);

/// The same with frames as they are cached, for `cached_scene`.
Status for_each_cached_frame(const ExportJob& job, const std::function<Status(const Frame&)>& use);

/// One body of a frame as points with what is known of them: a mesh's vertices, or particles.
struct ExportPoints {
  Points positions;                  ///< world [m]
  Points velocity;                   ///< [m/s]; no rows: not known
  Quaternions orientation;           ///< (w, x, y, z); no rows: not known
  Points size;                       ///< full extents of each point's own shape [m]; no rows: not known
  std::vector<const Channel*> other; ///< scalars per point, by name
  bool is_mesh = false;              ///< the body has triangles that index these points
};

/// Whether a body is a surface whose triangles index its own points; clouds of particles are not.
bool is_mesh(const SceneBody& body);

/// Errors: bad_input when the body has no positions.
Result<ExportPoints> export_points(const SceneBody& body, const FrameBody& frame);

/// A body's name as formats want it: letters, digits and underscores, not beginning with a digit.
std::string export_name(std::string_view name);

/// "bunny.0042.ply"
std::string sequence_name(std::string_view body, int frame, std::string_view extension);

} // namespace wry::pipeline
