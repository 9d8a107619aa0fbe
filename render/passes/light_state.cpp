#include "render/passes/light_state.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

namespace wry::render {
namespace {

constexpr double DEGREE = std::numbers::pi / 180.0;

Mat3 axes_of_light(const Vec3& towards) {
  const Vec3 helper = std::abs(towards.y()) < 0.9 ? Vec3(Vec3::UnitY()) : Vec3(Vec3::UnitX());
  Mat3 axes;
  axes.col(2) = towards.normalized();
  axes.col(0) = helper.cross(axes.col(2)).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

/// Point `index` of `count` of a spiral that fills the unit disc evenly (Vogel 1979).
Eigen::Vector2d disc_point(int index, int count) {
  const double radius = std::sqrt((index + 0.5) / count);
  const double angle = index * std::numbers::pi * (3.0 - std::sqrt(5.0));
  return radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

/// How far the light goes on from the lowest point of the bounds to a floor that lies deeper [m].
double way_to_floor(const RenderPlan& plan, const Vec3& towards) {
  if (plan.ground.kind == Ground::Kind::none || !plan.ground.height)
    return 0.0;
  double lowest = std::numeric_limits<double>::infinity();
  for (int corner = 0; corner < 8; ++corner)
    lowest =
        std::min(lowest, plan.up.dot(plan.bounds.box().corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner))));
  return std::max(lowest - *plan.ground.height, 0.0) / std::max(towards.dot(plan.up), 0.2);
}

/// Fits the shadow map to the box of the whole sequence: it neither clips nor swims while the subject moves. It reaches
/// down to the floor, or the penumbra there would be too narrow.
void fit_shadow_map(const RenderPlan& plan, const Mat3& axes, LightState& state) {
  Eigen::AlignedBox3d box;
  for (int corner = 0; corner < 8; ++corner)
    box.extend(axes.transpose() *
               (plan.bounds.box().corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)) - plan.bounds.centre()));
  const double side = 1.04 * std::max(box.sizes().x(), box.sizes().y()) + 1e-9;
  const double own_depth = 1.04 * box.sizes().z() + 1e-9;
  const double depth = own_depth + way_to_floor(plan, axes.col(2));
  const Vec3 centre = box.center();
  Eigen::Matrix4d light = Eigen::Matrix4d::Identity();
  light.topLeftCorner<3, 3>() = axes.transpose();
  Eigen::Matrix4d clip = Eigen::Matrix4d::Identity();
  clip.diagonal() << 2.0 / side, 2.0 / side, -1.0 / depth, 1.0;
  clip.topRightCorner<3, 1>() << -2.0 * centre.x() / side, -2.0 * centre.y() / side,
      (centre.z() + 0.5 * own_depth) / depth;
  state.light_from_world = light.cast<float>();
  state.clip_from_world_shadow = (clip * light).cast<float>();
  state.shadow_extent = static_cast<float>(side);
  state.shadow_depth = static_cast<float>(depth);
}

Eigen::Vector4f column(const Eigen::Vector3f& v, float last) {
  return Eigen::Vector4f(v.x(), v.y(), v.z(), last);
}

/// What the lights with or without shadows make a level white floor send back.
Eigen::Vector3f floor_light(const RenderPlan& plan, Light::Shadow shadow) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const Light& light : plan.rig.lights) {
    if (light.shadow == shadow)
      sum += light.radiance * static_cast<float>(std::max(0.0, std::sin(light.elevation_degrees * DEGREE)));
  }
  return sum;
}

} // namespace

LightState light_state(const RenderPlan& plan, double camera_azimuth_degrees, int index, int count) {
  LightState state;
  // The filter fills in what two sub-frames would see of the light's disc, unless the scene moves between them.
  state.frames_per_map = count >= 4 && !(plan.shutter > 0.0) ? 2 : 1;
  state.key_taps = state.frames_per_map > 1 ? 3 : KEY_TAPS_MAX;
  const int maps = (count + state.frames_per_map - 1) / state.frames_per_map;
  state.directions.setZero();
  state.radiances.setZero();
  for (const Light& light : plan.rig.lights) {
    const double spread = std::tan(light.angular_radius_degrees * DEGREE);
    Mat3 axes = axes_of_light(direction_to_light(light, plan.rig, plan.up, camera_azimuth_degrees));
    if (light.shadow == Light::Shadow::mapped) {
      const Eigen::Vector2d on_disc = spread * disc_point(index / state.frames_per_map, maps);
      axes = axes_of_light(axes * Vec3(on_disc.x(), on_disc.y(), 1.0));
      fit_shadow_map(plan, axes, state);
      state.shadow_spread = static_cast<float>(spread);
      state.shadow_share = static_cast<float>(1.0 / std::sqrt(static_cast<double>(maps)));
      state.shadowed = state.count;
    }
    const Eigen::Vector3f towards = axes.col(2).cast<float>();
    state.directions.col(state.count) =
        column(towards, static_cast<float>(std::sin(light.angular_radius_degrees * DEGREE)));
    state.radiances.col(state.count) = column(light.radiance, light.shadow == Light::Shadow::mapped ? 1.f : 0.f);
    ++state.count;
  }
  state.gain = static_cast<float>(std::exp2(plan.rig.stops));
  state.radiances.topRows<3>() *= state.gain;
  const double turned =
      (plan.rig.turning == Rig::Turning::with_camera ? camera_azimuth_degrees : 0.0) + plan.rig.turn_degrees;
  state.around = (world_frame(plan.up) * Eigen::AngleAxisd(turned * DEGREE, Vec3::UnitY())).cast<float>();
  state.sky = state.gain * plan.rig.sky;
  state.floor_key = state.gain * floor_light(plan, Light::Shadow::mapped);
  state.floor_others = state.gain * floor_light(plan, Light::Shadow::none);
  const Eigen::Vector3f floor = plan.ground.colour.cwiseProduct(state.sky + state.floor_key + state.floor_others);
  state.bounce = 0.8f * floor;
  if (plan.rig.bounce == Rig::Bounce::given)
    state.bounce = plan.rig.given_bounce;
  state.backdrop = floor;
  if (plan.rig.backdrop == Rig::Backdrop::given || plan.ground.kind == Ground::Kind::none)
    state.backdrop = plan.rig.given_backdrop;
  return state;
}

} // namespace wry::render
