#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "sim/base/result.h"
#include "sim/base/types.h"

namespace wry::pipeline {

/// The vertices of a mesh file in the file's own order, which point caches and sequences go by and importers change.
struct NumberedVertices {
  Points positions;                ///< in units and axes of the file
  std::vector<std::int32_t> faces; ///< equal for files of the same faces: of OBJ all corners, of PLY how many triangles
};

/// Reads an .obj or .ply file. Errors: missing_input, io; bad_input naming file and line: another format, a coordinate
/// or an index that is none, no vertices.
Result<NumberedVertices> read_numbered_vertices(const std::filesystem::path& path);

} // namespace wry::pipeline
