#pragma once

#include <string_view>

#include "pipeline/assets/import_protocol.h"

namespace wry::pipeline {

/// Reads a PLY file: ASCII, binary little- or big-endian 1.0. Polygons are cut into triangles. Vertex colours become
/// the attribute "colour" (0..1), s/t or u/v "uv", normals are left out, every other scalar of the vertices an
/// attribute of its name. Memory stays in proportion to the file, whatever its header claims. Errors: bad_input with
/// the line or byte: a damaged header, an early end, values that are no numbers, indices out of range, no faces.
Result<RawMesh> read_ply(std::string_view bytes);

} // namespace wry::pipeline
