#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/base/types.h"

namespace wry::pipeline {

/// Cuts a polygon into corners.size() - 2 triangles with its sense, by ears in the plane of its mean normal, the
/// roundest ear first; also concave ones. Where no ear is left (a polygon that crosses itself or has no area), by a
/// fan. `points` are those of the corners, in order, finite.
std::vector<std::array<std::int32_t, 3>> triangulate_polygon(std::span<const std::int32_t> corners,
                                                             std::span<const Vec3> points);

} // namespace wry::pipeline
