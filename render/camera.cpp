#include "render/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace wry::render {
namespace {

constexpr double FILM_WIDTH_MM = 36.0;
constexpr int ORBIT_STOPS = 96;

Mat3 axes_looking(const Vec3& back, const Vec3& up) {
  Mat3 axes;
  axes.col(2) = back.normalized();
  axes.col(0) = up.cross(axes.col(2)).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

/// Where the camera must stand, in its own axes, to see every point between planes of slope `tangents`:
/// |x - eye_x| <= tangent_x * (eye_z - z), and the same for y. The nearest such eye.
Vec3 nearest_eye(const Points& in_camera_axes, const Eigen::Vector2d& tangents) {
  Vec3 eye(0, 0, -std::numeric_limits<double>::infinity());
  for (int side = 0; side < 2; ++side) {
    double plus = -std::numeric_limits<double>::infinity();
    double minus = -std::numeric_limits<double>::infinity();
    for (Eigen::Index i = 0; i < in_camera_axes.rows(); ++i) {
      plus = std::max(plus, in_camera_axes(i, side) + tangents[side] * in_camera_axes(i, 2));
      minus = std::max(minus, -in_camera_axes(i, side) + tangents[side] * in_camera_axes(i, 2));
    }
    eye[side] = 0.5 * (plus - minus);
    eye.z() = std::max(eye.z(), 0.5 * (plus + minus) / tangents[side]);
  }
  return eye;
}

/// The outline, and for an orbit the outline at every stop of the turn, about the vertical through the box's centre.
Points points_to_frame(const SubjectBounds& bounds, const Vec3& up, Framing framing) {
  const Points centred = bounds.outline().rowwise() - bounds.centre().transpose();
  if (framing == Framing::still)
    return centred;
  Points all(centred.rows() * ORBIT_STOPS, 3);
  for (int stop = 0; stop < ORBIT_STOPS; ++stop) {
    const Eigen::AngleAxisd turn(2.0 * std::numbers::pi * stop / ORBIT_STOPS, up);
    all.middleRows(stop * centred.rows(), centred.rows()) = centred * turn.toRotationMatrix().transpose();
  }
  return all;
}

Status check(const CameraPlan& plan, const SubjectBounds& bounds, const ImageSize& size) {
  if (bounds.empty())
    return make_error(ErrorCode::bad_input, "there is nothing to look at: no body of the scene has triangles");
  if (size.width < 16 || size.height < 16 || size.width > 16384 || size.height > 16384)
    return make_error(ErrorCode::bad_input, "a picture of {} x {} pixels: each side must be 16 to 16384", size.width,
                      size.height);
  if (!(plan.lens_mm >= 10.0 && plan.lens_mm <= 1000.0))
    return make_error(ErrorCode::bad_input, "a lens of {} mm: choose 10 to 1000", plan.lens_mm);
  if (!(std::abs(plan.elevation_degrees) <= 89.0) || !std::isfinite(plan.azimuth_degrees))
    return make_error(ErrorCode::bad_input, "a camera at azimuth {}, elevation {} degrees: elevation must be -89 to 89",
                      plan.azimuth_degrees, plan.elevation_degrees);
  if (!(plan.margin >= 0.0 && plan.margin <= 0.9))
    return make_error(ErrorCode::bad_input, "a margin of {} around the subject: choose 0 to 0.9", plan.margin);
  return {};
}

Result<Camera> place_camera(const PlacedCamera& placed, const Vec3& up, Camera camera, double turns) {
  const Vec3 arm = placed.eye - placed.target;
  if (!(arm.norm() > 0.0) || !arm.allFinite())
    return make_error(ErrorCode::bad_input, "the camera's eye and target are the same point: move one of them");
  const Eigen::AngleAxisd turn(2.0 * std::numbers::pi * turns, up);
  const Vec3 turned = turn * arm;
  const Vec3 upward = placed.up ? Vec3(turn * *placed.up) : up;
  if (turned.normalized().cross(upward).norm() < 1e-6)
    return make_error(ErrorCode::bad_input, "the camera looks straight along its up axis: tilt it a little");
  camera.eye = placed.target + turned;
  camera.axes = axes_looking(turned, upward);
  return camera;
}

/// A plane in front of the nearest part of the subject, and never behind the eye.
double near_distance(const Camera& camera, const SubjectBounds& bounds) {
  double nearest = std::numeric_limits<double>::infinity();
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 point = bounds.box().corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    nearest = std::min(nearest, -camera.axes.col(2).dot(point - camera.eye));
  }
  return std::max(0.5 * nearest, 1e-3 * bounds.radius());
}

} // namespace

Mat3 world_frame(const Vec3& up) {
  const Vec3 y = up.normalized();
  const Vec3 towards = std::abs(y.z()) > 0.9 ? Vec3(0, -1, 0) : Vec3(0, 0, 1);
  Mat3 frame;
  frame.col(1) = y;
  frame.col(2) = (towards - towards.dot(y) * y).normalized();
  frame.col(0) = y.cross(frame.col(2));
  return frame;
}

double turntable_turns(int index, int count) {
  return static_cast<double>(index) / static_cast<double>(count);
}

Result<Camera> frame_camera(const CameraPlan& plan, const Vec3& up, const SubjectBounds& bounds, const ImageSize& size,
                            Framing framing, double orbit_turns) {
  if (const Status good = check(plan, bounds, size); !good.ok())
    return good.error();
  Camera camera;
  camera.tan_half_width = 0.5 * FILM_WIDTH_MM / plan.lens_mm;
  camera.tan_half_height = camera.tan_half_width * size.height / size.width;
  if (plan.placed.has_value()) {
    Result<Camera> placed = place_camera(*plan.placed, up, camera, orbit_turns);
    if (placed.ok())
      placed->near_distance = near_distance(*placed, bounds);
    return placed;
  }
  constexpr double DEGREE = std::numbers::pi / 180.0;
  const double azimuth = plan.azimuth_degrees * DEGREE + 2.0 * std::numbers::pi * orbit_turns;
  const double elevation = plan.elevation_degrees * DEGREE;
  const Vec3 back = world_frame(up) * Vec3(std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                                           std::cos(elevation) * std::cos(azimuth));
  camera.axes = axes_looking(back, up);
  const Eigen::Vector2d tangents = (1.0 - plan.margin) * Eigen::Vector2d(camera.tan_half_width, camera.tan_half_height);
  const Points in_axes = points_to_frame(bounds, up, framing) * camera.axes;
  camera.eye = bounds.centre() + camera.axes * nearest_eye(in_axes, tangents);
  camera.near_distance = near_distance(camera, bounds);
  return camera;
}

} // namespace wry::render
