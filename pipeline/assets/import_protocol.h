#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sim/base/result.h"
#include "sim/geometry/surface_mesh.h"

namespace wry::pipeline {

/// What a mesh file holds, before anything is done to it: in the file's units and axes.
struct RawMesh {
  geometry::SurfaceMesh mesh;
  std::vector<std::string> notes; ///< what the user should know, a sentence each
};

/// The answer of an import process: a mesh, or why there is none. Little-endian, flat.
std::string encode_answer(const Result<RawMesh>& answer);

/// Reads an answer that may have been written by a process under attack: every count, index and length is checked
/// against the bytes that are there, text is reduced to printable characters. Errors: those of the answer itself, or io
/// when it makes no sense.
Result<RawMesh> decode_answer(std::span<const std::byte> bytes);

} // namespace wry::pipeline
