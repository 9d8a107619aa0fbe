#include "render/lights.h"

#include <cmath>
#include <numbers>

#include "render/camera.h"

namespace wry::render {

Rig studio_rig() {
  Rig rig;
  Light key;
  key.azimuth_degrees = -42;
  key.elevation_degrees = 46;
  key.radiance = {1.46f, 1.38f, 1.25f};
  key.angular_radius_degrees = 4.5;
  key.shadow = Light::Shadow::mapped;
  Light fill;
  fill.azimuth_degrees = 58;
  fill.elevation_degrees = 22;
  fill.radiance = {.12f, .138f, .165f};
  fill.angular_radius_degrees = 18;
  Light rim;
  rim.azimuth_degrees = 158;
  rim.elevation_degrees = 36;
  rim.radiance = {.80f, .84f, .92f};
  rim.angular_radius_degrees = 7;
  rig.lights = {key, fill, rim};
  rig.sky = {.165f, .18f, .205f};
  return rig;
}

Vec3 direction_to_light(const Light& light, const Rig& rig, const Vec3& up, double camera_azimuth_degrees) {
  constexpr double DEGREE = std::numbers::pi / 180.0;
  const double from = rig.turning == Rig::Turning::with_camera ? camera_azimuth_degrees : 0.0;
  const double azimuth = (from + rig.turn_degrees + light.azimuth_degrees) * DEGREE;
  const double elevation = light.elevation_degrees * DEGREE;
  return world_frame(up) *
         Vec3(std::cos(elevation) * std::sin(azimuth), std::sin(elevation), std::cos(elevation) * std::cos(azimuth));
}

} // namespace wry::render
