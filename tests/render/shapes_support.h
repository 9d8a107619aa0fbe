#pragma once

#include "sim/geometry/surface_mesh.h"

namespace wry::render::testing {

/// Sphere of rings x segments quads about `centre`, closed at the poles.
geometry::SurfaceMesh sphere(const Vec3& centre, double radius, int rings, int segments);

/// Torus about the y axis.
geometry::SurfaceMesh torus(const Vec3& centre, double radius, double tube, int rings, int segments);

/// Axis-aligned box of 12 triangles.
geometry::SurfaceMesh box(const Vec3& low, const Vec3& high);

/// A lumpy closed body that stands on y = 0, about 1 m tall.
geometry::SurfaceMesh pebble(int rings, int segments);

/// Both meshes in one.
geometry::SurfaceMesh joined(const geometry::SurfaceMesh& a, const geometry::SurfaceMesh& b);

} // namespace wry::render::testing
