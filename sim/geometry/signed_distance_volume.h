#pragma once

#include <functional>

#include "sim/geometry/isosurface_stuffing.h"

namespace wry::geometry {

/// Volume [m^3] of {low < distance < high} inside `bounds`, for a function that changes by at most 1 per metre (a
/// signed distance), by dividing space down to cells of `cell` [m] near the two surfaces. The error falls as cell
/// squared.
double volume_between(const DistanceFunction& distance, const Bounds& bounds, double low, double high, double cell);

} // namespace wry::geometry
