#include "sim/scene/transform.h"

#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace wry::scene {

namespace {

// sin and cos of degrees, exact at multiples of a quarter turn, so that turned boxes stay axis-aligned to the last bit.
Eigen::Vector2d cos_sin_degrees(double degrees) {
  const double turned = std::remainder(degrees, 360.0);
  const double quarters = std::nearbyint(turned / 90.0);
  const double rest = (turned - 90.0 * quarters) * std::numbers::pi / 180.0;
  const double c = std::cos(rest);
  const double s = std::sin(rest);
  switch ((static_cast<int>(quarters) + 4) % 4) {
  case 0:
    return {c, s};
  case 1:
    return {-s, c};
  case 2:
    return {-c, -s};
  default:
    return {s, -c};
  }
}

// Rodrigues' formula about a unit axis.
Mat3 turn_about(const Vec3& axis, double degrees) {
  const Eigen::Vector2d cs = cos_sin_degrees(degrees);
  Mat3 cross;
  cross << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  return cs[0] * Mat3::Identity() + cs[1] * cross + (1 - cs[0]) * axis * axis.transpose();
}

// Axes in the order in which they turn.
std::array<int, 3> order_of(EulerOrder order) {
  switch (order) {
  case EulerOrder::xyz:
    return {0, 1, 2};
  case EulerOrder::xzy:
    return {0, 2, 1};
  case EulerOrder::yxz:
    return {1, 0, 2};
  case EulerOrder::yzx:
    return {1, 2, 0};
  case EulerOrder::zxy:
    return {2, 0, 1};
  default:
    return {2, 1, 0};
  }
}

double measured_extent(SizeMeasure measure, Axis up, const Vec3& extent) {
  const int height = geometry::axis_index(up);
  const int width = up == Axis::x ? 1 : 0;
  switch (measure) {
  case SizeMeasure::height:
    return extent[height];
  case SizeMeasure::width:
    return extent[width];
  case SizeMeasure::depth:
    return extent[3 - height - width];
  default:
    return extent.maxCoeff();
  }
}

} // namespace

Result<Mat3> rotation_matrix(const AxisTurn& turn) {
  const double length = turn.axis.stableNorm();
  if (!(length > 0) || !std::isfinite(length) || !std::isfinite(turn.degrees))
    return make_error(
        ErrorCode::bad_input,
        "a rotation needs an axis that is not zero and a finite angle; it has ({}, {}, {}) and {} degrees",
        turn.axis.x(), turn.axis.y(), turn.axis.z(), turn.degrees);
  return turn_about(turn.axis / length, turn.degrees);
}

Mat3 rotation_matrix(const Vec3& degrees, EulerOrder order) {
  Mat3 rotation = Mat3::Identity();
  for (const int axis : order_of(order))
    rotation = (turn_about(Vec3::Unit(axis), degrees[axis]) * rotation).eval();
  return rotation;
}

Mat3 up_rotation(Axis from, Axis to) {
  if (from == to)
    return Mat3::Identity();
  const Vec3 axis = geometry::axis_direction(from).cross(geometry::axis_direction(to));
  return turn_about(axis, 90);
}

Result<Similarity> placement_similarity(const Placement& placement, const Vec3& extent) {
  Similarity similarity;
  similarity.scale = placement.scale;
  if (placement.size) {
    const double present = measured_extent(placement.size->measure, placement.up, extent);
    if (!(present > 0))
      return make_error(ErrorCode::bad_input, "the body has no extent ({} x {} x {} m) along the one that size sets",
                        extent.x(), extent.y(), extent.z());
    if (!(placement.size->length > 0))
      return make_error(ErrorCode::bad_input, "size must be positive; it is {} m", placement.size->length);
    similarity.scale = placement.size->length / present;
  }
  if (!(similarity.scale > 0) || !std::isfinite(similarity.scale))
    return make_error(ErrorCode::bad_input, "scale must be positive and finite; it is {}", similarity.scale);
  if (!placement.translate.allFinite())
    return make_error(ErrorCode::bad_input, "translate must be finite");
  for (const AxisTurn& turn : placement.rotate) {
    const Result<Mat3> rotation = rotation_matrix(turn);
    if (!rotation)
      return rotation.error();
    similarity.rotation = (*rotation * similarity.rotation).eval();
  }
  similarity.translation = placement.translate;
  return similarity;
}

void apply(const Similarity& similarity, Points& points) {
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Vec3 point = points.row(i).transpose();
    points.row(i) = similarity.apply(point).transpose();
  }
}

} // namespace wry::scene
