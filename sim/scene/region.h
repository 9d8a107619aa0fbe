#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "sim/base/parallel.h"
#include "sim/base/result.h"
#include "sim/scene/rest_points.h"

namespace wry::scene {

/// Points within a box, borders included.
struct BoxRegion {
  Vec3 min = Vec3::Zero(); ///< [m]
  Vec3 max = Vec3::Zero(); ///< [m]
};

/// Points no further than `radius` from `centre`.
struct SphereRegion {
  Vec3 centre = Vec3::Zero(); ///< [m]
  double radius = 0;          ///< [m]
};

/// Points no further than `radius` from the axis, between its ends.
struct CylinderRegion {
  Vec3 from = Vec3::Zero(); ///< [m]
  Vec3 to = Vec3::UnitY();  ///< [m]
  double radius = 0;        ///< [m]
};

/// Points where a formula of X, Y, Z, u, v and attributes is not zero, e.g. "Y < 0.02".
struct ExpressionRegion {
  std::string text;
};

/// Points where the attribute (its length, if it has several components) is above the threshold.
struct AttributeRegion {
  std::string name;
  double threshold = 0.5;
};

/// `where` of the shot file.
using Region = std::variant<BoxRegion, SphereRegion, CylinderRegion, ExpressionRegion, AttributeRegion>;

/// Indices of the points in the region, ascending. Borders reach 1e-9 of the points' extent further, so that a face at
/// exactly the border is in. Errors: bad_input for a region without an inside, a formula that fails or depends on t, an
/// unknown attribute (the known ones are named), and when no point is in it (the extents of the points are named).
Result<std::vector<std::int32_t>> select_points(const Region& region, const RestPoints& points, const Threads& threads);

} // namespace wry::scene
