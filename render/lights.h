#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "render/image.h"
#include "sim/base/types.h"

namespace wry::render {

/// A far area light: a disc in the sky.
struct Light {
  enum class Shadow { none, mapped };
  double azimuth_degrees = 0;    ///< to the right of the camera (Rig::Turning::with_camera) or of the world's front
  double elevation_degrees = 45; ///< above the horizon
  Eigen::Vector3f radiance = Eigen::Vector3f::Ones(); ///< what a white matt surface facing it sends back
  double angular_radius_degrees = 2;                  ///< half the disc: softness of its shadow and of its highlight
  Shadow shadow = Shadow::none;
};

/// All the light of a picture: at most four far lights, and a sky over a ground that sends light back up.
struct Rig {
  /// A turntable turns the subject under fixed lights (with_camera) or the camera around a lit set (with_world).
  enum class Turning { with_camera, with_world };
  Turning turning = Turning::with_camera;
  std::vector<Light> lights; ///< at most one of them with a mapped shadow
  Eigen::Vector3f sky = Eigen::Vector3f::Constant(.4f);
  /// Light from below; `automatic` computes it from what falls on the ground.
  enum class Bounce { automatic, given };
  Bounce bounce = Bounce::automatic;
  Eigen::Vector3f given_bounce = Eigen::Vector3f::Zero();
  /// Whether hollows and contacts are darkened by what surrounds them.
  enum class Occlusion { none, near_by };
  Occlusion occlusion = Occlusion::near_by;
  /// Backdrop behind everything; with a studio ground, `melted` gives it the ground's own light;
  /// `surroundings` shows the picture that lights the scene.
  enum class Backdrop { melted, given, surroundings };
  Backdrop backdrop = Backdrop::melted;
  Eigen::Vector3f given_backdrop = Eigen::Vector3f::Constant(.18f);
  /// Light from all around, equirectangular (up in the middle of the top row, azimuth 0 in the middle column): in place
  /// of the even `sky`, which still lights the floor. Absent: the sky is even.
  std::shared_ptr<const LinearImage> surroundings;
  double turn_degrees = 0.0; ///< of all lights about up
  double stops = 0.0;        ///< of all lights
};

/// Key from the upper left, large soft fill from the right, rim from behind, sky and ground bounce.
Rig studio_rig();

/// Unit direction towards a light, in the world. `camera_azimuth_degrees`: the camera's, for Turning::with_camera.
Vec3 direction_to_light(const Light& light, const Rig& rig, const Vec3& up, double camera_azimuth_degrees);

} // namespace wry::render
