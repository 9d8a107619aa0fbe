#pragma once

#include "sim/base/types.h"

namespace wry::make {

/// Approximate signed distance to a sitting rabbit that looks along +z, y up, its base in the plane y = 0, about one
/// metre tall: negative inside. Smooth unions of ellipsoids and round cones; every convex part is rounder than about
/// 3 cm, so that 2 cm walls can be hollowed everywhere.
double bunny_distance(const Vec3& point);

} // namespace wry::make
