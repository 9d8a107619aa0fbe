#include "sim/geometry/primitives.h"

#include <cmath>
#include <numbers>

namespace wry::geometry {

namespace {

constexpr double PI = std::numbers::pi;

Status check_lengths(const Vec3& lengths, double target_edge, const char* what) {
  for (int i = 0; i < 3; ++i) {
    if (!(lengths[i] > 0) || !std::isfinite(lengths[i]))
      return make_error(ErrorCode::bad_input, "{} needs positive, finite sizes; one of them is {} m", what, lengths[i]);
  }
  if (!(target_edge > 0) || !std::isfinite(target_edge))
    return make_error(ErrorCode::bad_input, "{} needs a positive target edge (resolution); it is {} m", what,
                      target_edge);
  return {};
}

// Concentric squares in [-1, 1]^2 to concentric circles.
Eigen::Vector2d square_to_disc(double x, double y) {
  if (x == 0 && y == 0)
    return Eigen::Vector2d::Zero();
  if (std::abs(x) >= std::abs(y)) {
    const double angle = PI / 4 * (y / x);
    return {x * std::cos(angle), x * std::sin(angle)};
  }
  const double angle = PI / 4 * (x / y);
  return {y * std::sin(angle), y * std::cos(angle)};
}

} // namespace

Block box_block(const Vec3& size) {
  Block block;
  block.size = size;
  return block;
}

Block rod_block(double length, double width, double height, Section section, Axis axis) {
  Block block;
  block.section = section;
  block.axis = axis;
  block.u_axis = axis;
  block.v_axis = next_axis(next_axis(axis));
  block.size[axis_index(axis)] = length;
  block.size[axis_index(next_axis(axis))] = height;
  block.size[axis_index(block.v_axis)] = width;
  return block;
}

Block cylinder_block(double radius, double height, Axis axis) {
  return rod_block(height, 2 * radius, 2 * radius, Section::round, axis);
}

Block sheet_block(double width, double depth, double thickness, Axis normal) {
  Block block = rod_block(thickness, width, depth, Section::box, normal);
  block.u_axis = next_axis(next_axis(normal));
  block.v_axis = next_axis(normal);
  return block;
}

Result<std::array<int, 3>> cells_for_edge(const Block& block, double target_edge) {
  if (Status status = check_lengths(block.size, target_edge, "a block"); !status)
    return status.error();
  constexpr double MAX_CELLS = 1e8;
  // A size that is a whole number of edges up to round-off gets exactly that many cells.
  const Vec3 exact =
      (block.size / target_edge).unaryExpr([](double n) { return std::max(1.0, std::ceil(n - 1e-9 * n)); });
  if (!(exact.prod() <= MAX_CELLS))
    return make_error(
        ErrorCode::bad_input,
        "a block of {} x {} x {} m with edges of {} m has {:.3g} cells; the limit is {:.0e}: use a longer edge",
        block.size.x(), block.size.y(), block.size.z(), target_edge, exact.prod(), MAX_CELLS);
  std::array<int, 3> cells = {static_cast<int>(exact[0]), static_cast<int>(exact[1]), static_cast<int>(exact[2])};
  if (block.section == Section::round) {
    int& first = cells[axis_index(next_axis(block.axis))];
    int& second = cells[axis_index(next_axis(next_axis(block.axis)))];
    first = second = (std::max(first, second) + 1) / 2 * 2;
  }
  return cells;
}

Vec3 block_point(const Block& block, const Vec3& s) {
  Vec3 centred = 2 * s - Vec3::Ones();
  if (block.section == Section::round) {
    const int first = axis_index(next_axis(block.axis));
    const int second = axis_index(next_axis(next_axis(block.axis)));
    const Eigen::Vector2d disc = square_to_disc(centred[first], centred[second]);
    centred[first] = disc[0];
    centred[second] = disc[1];
  }
  return 0.5 * centred.cwiseProduct(block.size);
}

} // namespace wry::geometry
