#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/base/result.h"
#include "sim/base/types.h"
#include "sim/scene/transform.h"

namespace wry::pipeline {

/// A mesh that was imported and placed, and where to find it over time.
struct MeshSequenceSource {
  std::string mesh;                          ///< the .obj or .ply file that was imported
  std::string sequence;                      ///< a .pc2 file, or numbered meshes: digits of the frame for each #
  std::vector<scene::Similarity> placements; ///< from the file's units and axes to where the collider rests, in turn
  int first_frame = 1, last_frame = 1;       ///< that it has to cover
};

/// A mesh over the frames.
struct ImportedMeshSequence {
  std::vector<Points> samples; ///< positions of all vertices of the imported mesh [m]
  double first_frame = 1.0;    ///< of the first sample
  double frames_per_sample = 1.0;
  std::vector<std::string> files; ///< all that were read
};

/// Finds the vertices of `placed` (vertices x 3 [m], welded) in the file it came from, and where they go. Errors:
/// missing_input for a file, naming the frame; bad_input: frames that are not covered, a file whose vertices or faces
/// are not those of the mesh, a number that is none, vertices at one place that come apart.
Result<ImportedMeshSequence> import_mesh_sequence(const MeshSequenceSource& source, const Points& placed);

} // namespace wry::pipeline
