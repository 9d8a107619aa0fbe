#pragma once

#include "sim/geometry/surface_mesh.h"

namespace wry::mpm {

/// Closed, outward.
geometry::SurfaceMesh box_mesh(const Vec3& low, const Vec3& high);

/// A closed mesh: a box with a pocket from above that leaves walls and a floor of this thickness [m].
geometry::SurfaceMesh tank(const Vec3& low, const Vec3& high, double wall);

} // namespace wry::mpm
