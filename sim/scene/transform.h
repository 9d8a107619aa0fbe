#pragma once

#include <optional>
#include <vector>

#include "sim/base/result.h"
#include "sim/geometry/axis.h"

namespace wry::scene {

using geometry::Axis;

/// A turn about an axis through the origin, counter-clockwise seen against the axis.
struct AxisTurn {
  Vec3 axis = Vec3::UnitY(); ///< not zero; need not be of unit length
  double degrees = 0;
};

/// The order in which the turns about the fixed axes are done: xyz is x first, z last.
enum class EulerOrder { xyz, xzy, yxz, yzx, zxy, zyx };

/// Errors: bad_input for a zero axis or numbers that are not finite.
Result<Mat3> rotation_matrix(const AxisTurn& turn);

/// Turns about the fixed x, y, z axes by `degrees`, in that order.
Mat3 rotation_matrix(const Vec3& degrees, EulerOrder order);

/// The quarter turn that takes one up axis to another, about the axis that is neither; z up to y up: (x, y, z) -> (x,
/// z, -y).
Mat3 up_rotation(Axis from, Axis to);

/// Which extent `size` sets: height is along up, width along x (y when up is x), depth along the remaining axis.
enum class SizeMeasure { height, width, depth, max };

struct SizeRule {
  SizeMeasure measure = SizeMeasure::height;
  double length = 1; ///< [m]
};

/// How a body comes from its mesh file or primitive into the shot's world: about the origin, in the order of the
/// members.
struct Placement {
  Axis up = Axis::y;             ///< of the shot; what height, width and depth refer to
  std::optional<SizeRule> size;  ///< scaled evenly until the extent has this length
  double scale = 1;              ///< used when there is no size
  std::vector<AxisTurn> rotate;  ///< one after the other
  Vec3 translate = Vec3::Zero(); ///< [m]
};

/// A similarity: x -> scale * rotation x + translation.
struct Similarity {
  double scale = 1;
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero(); ///< [m]

  Vec3 apply(const Vec3& point) const { return scale * (rotation * point) + translation; }
};

/// The similarity that places points of these extents [m]. Errors: bad_input for a size or scale that is not positive,
/// a zero axis, or an extent of zero that should be scaled.
Result<Similarity> placement_similarity(const Placement& placement, const Vec3& extent);

/// Moves the points, a row each.
void apply(const Similarity& similarity, Points& points);

} // namespace wry::scene
