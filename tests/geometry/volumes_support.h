#pragma once

#include <string>

#include "sim/geometry/surface_mesh.h"
#include "sim/geometry/tet_mesh.h"

namespace wry::geometry {

/// The bunny that ships.
SurfaceMesh bunny_surface();

/// The boundary of a tet mesh as a surface.
SurfaceMesh boundary_surface(const TetMesh& mesh);

/// Pairs of boundary triangles that cut each other.
std::size_t boundary_self_intersections(const TetMesh& mesh);

/// A copy without its first `count` triangles.
SurfaceMesh without_triangles(const SurfaceMesh& mesh, int count);

/// A box with rounded edges, as a fine mesh.
SurfaceMesh rounded_box(const Vec3& half_size, double radius, double edge);

} // namespace wry::geometry
