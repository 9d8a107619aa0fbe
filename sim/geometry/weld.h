#pragma once

#include <cstdint>
#include <vector>

#include "sim/base/result.h"
#include "sim/geometry/surface_mesh.h"

namespace wry::geometry {

/// A mesh whose vertices at one place became one.
struct WeldedMesh {
  SurfaceMesh mesh;
  std::vector<std::int32_t> map;      ///< old vertex -> new vertex; -1: unused, left out
  std::int64_t merged_vertices = 0;   ///< went into an earlier one
  std::int64_t unused_vertices = 0;   ///< belonged to no triangle, left out
  std::int64_t dropped_triangles = 0; ///< had two corners at one place, or were there already
};

/// Joins vertices no further apart than `tolerance` [m] (0: exactly equal), in order of their indices: a vertex joins
/// the earliest kept one within reach, so nothing moves and attributes are those of the first. Triangles that collapse
/// and triangles with the same vertices as an earlier one are dropped, unused vertices too. Errors: bad_input for
/// indices out of range, coordinates that are not finite, or a tolerance that is negative or too small against the
/// coordinates to be resolved.
Result<WeldedMesh> weld(const SurfaceMesh& mesh, double tolerance);

} // namespace wry::geometry
