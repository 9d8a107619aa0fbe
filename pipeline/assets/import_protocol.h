#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "render/mesh_appearance.h"
#include "sim/base/result.h"
#include "sim/geometry/surface_mesh.h"

namespace wry::pipeline {

/// Row-major, a column of coordinates from the right.
using RawTransform = std::array<double, 16>;

/// Where a node of a scene file is over time, in the file's units and axes.
struct RawMotion {
  RawTransform rest = {};               ///< as the file stands without its animation
  std::vector<double> times;            ///< [s], ascending; empty: nothing moves it
  std::vector<RawTransform> transforms; ///< one per time
  double camera_fov = 0.0;              ///< horizontal [rad]; 0: the node is no camera. Cameras look along -z, +y is up
};

/// What is wanted of a mesh file.
enum class ImportWhat { mesh, motion };

/// What a mesh file holds, before anything is done to it: in the file's units and axes.
struct RawMesh {
  geometry::SurfaceMesh mesh;                     ///< empty when only the motion was wanted
  RawMotion motion;                               ///< of the node, when it was wanted
  std::vector<std::string> notes;                 ///< what the user should know, a sentence each
  std::vector<std::int32_t> material_of_triangle; ///< a row of `materials`; empty: the file has none
  std::vector<render::ArtistMaterial> materials;
  std::vector<render::Image> textures; ///< that materials name
};

/// The answer of an import process: a mesh, or why there is none. Little-endian, flat.
std::string encode_answer(const Result<RawMesh>& answer);

/// Reads an answer that may have been written by a process under attack: every count, index and length is checked
/// against the bytes that are there, text is reduced to printable characters. Errors: those of the answer itself, or io
/// when it makes no sense.
Result<RawMesh> decode_answer(std::span<const std::byte> bytes);

} // namespace wry::pipeline
