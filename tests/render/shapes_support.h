#pragma once

#include "render/mesh_scene.h"
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

/// A heap of grains in random directions, half full, on y = 0: a cone of about `count` of them, 1 m wide. The size
/// of a grain is scaled so that the heap has that width.
render::MeshScene heap(int count, const Grain& grain, const std::string& look);

} // namespace wry::render::testing
