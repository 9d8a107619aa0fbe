#pragma once

#include "sim/base/types.h"

namespace wry::geometry {

/// Sign of (a - d) x (b - d) . (c - d), exact for finite coordinates whose products neither overflow nor underflow:
/// floating point with Shewchuk's error bound first, expansions when that is not enough (Shewchuk 1997).
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Sign of the doubled area of the plane triangle a, b, c; exact likewise.
int orientation(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c);

/// Whether the closed segment p q meets the closed triangle a b c (with area), exactly.
bool segment_meets_triangle(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c);

/// Whether c and d lie in one plane with the edge a b and on the same side of it.
bool folds_onto(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

} // namespace wry::geometry
