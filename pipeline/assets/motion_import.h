#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/assets/mesh_import.h"
#include "sim/base/result.h"
#include "sim/scene/motion.h"

namespace wry::pipeline {

/// Where a node of an artist's file is over time, in metres and the scene's axes.
struct ImportedMotion {
  scene::Pose rest;                       ///< as the file stands without its animation
  std::vector<scene::PoseSample> samples; ///< poses of the node in the scene; empty: nothing moves it
  /// Horizontal opening [rad] when the node is a camera, which looks along its -z with its +y up.
  std::optional<double> camera_fov;

  /// What takes matter that rests where the file stands to where it is: pose(t) rest^-1. Error: bad_input when nothing
  /// moves it.
  Result<scene::Motion> relative_motion() const;
};

/// Reads the motion of `options.node` (empty: the first camera) from the first animation of a glTF, FBX or DAE file, in
/// a process of its own. A node that scales evenly is taken without its scale; what stretches or mirrors over time is
/// refused. Errors: those of import_mesh.
Result<ImportedMotion> import_motion(const std::string& path, const MeshImportOptions& options);

} // namespace wry::pipeline
