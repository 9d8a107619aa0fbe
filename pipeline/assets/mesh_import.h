#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/assets/sandbox.h"
#include "render/mesh_appearance.h"
#include "sim/base/result.h"
#include "sim/geometry/axis.h"
#include "sim/geometry/mesh_checks.h"
#include "sim/geometry/surface_mesh.h"

namespace wry::pipeline {

/// Whether a mesh must bound a volume.
enum class Closedness { any, closed };

/// How an artist's file becomes a mesh in metres.
struct MeshImportOptions {
  double metres_per_unit = 1;                  ///< what one unit of the file is [m]
  geometry::Axis up = geometry::Axis::y;       ///< the file's up axis
  geometry::Axis scene_up = geometry::Axis::y; ///< what it is turned to
  std::string node;                            ///< only what hangs from the node of this name; empty: all of the file
  std::optional<double> weld_tolerance;        ///< [m]; absent: 1e-6 of the diagonal of the bounding box
  Closedness closedness = Closedness::any;     ///< `closed`: an open mesh is an error that names the hole
  SandboxLimits limits;                        ///< of the process that reads the file
  std::string program;                         ///< see ImportProcess; empty: this very program
};

/// A mesh in metres, welded, its triangles agreeing and turned outward.
struct ImportedMesh {
  geometry::SurfaceMesh mesh;     ///< with vertex colours as attribute "colour", texture coordinates as "uv"
  geometry::MeshReport report;    ///< of `mesh`
  std::vector<std::string> notes; ///< what the user should know, a sentence each; the size in metres is the first
  std::optional<render::MeshAppearance> appearance; ///< materials and pictures, when the file has any
};

/// Reads an artist's mesh (ply by our own reader; obj, stl, off, gltf, glb, fbx, 3ds, dae by assimp) in a process of
/// its own, whose answer is checked value by value, then scales it to metres, turns it upright, welds and orients it.
/// Errors: missing_input; bad_input naming the file and what is wrong: unknown format, damaged (with the signal or the
/// limit when the reader crashed or ran away), not finite, without area, open where it must be closed; unavailable
/// without assimp.
Result<ImportedMesh> import_mesh(const std::string& path, const MeshImportOptions& options = {});

/// Whether the path names a file of a format that is read. Errors: missing_input, bad_input naming the formats.
Status check_mesh_path(const std::string& path);

} // namespace wry::pipeline
