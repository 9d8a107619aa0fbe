#pragma once

#include <Eigen/Core>

#include "render/render_plan.h"

namespace wry::render {

constexpr int LIGHTS_MAX = 4;
constexpr int KEY_TAPS_MAX = 4;

/// The lights of one sub-frame as the shaders read them. Positions are relative to the centre of the plan's bounds.
struct LightState {
  int count = 0;
  int shadowed = -1;                              ///< index of the light with the shadow map, or -1
  Eigen::Matrix<float, 4, LIGHTS_MAX> directions; ///< columns: unit direction to the light, sine of its angular radius
  Eigen::Matrix<float, 4, LIGHTS_MAX> radiances;  ///< columns: rgb, 1 for the shadowed light
  Eigen::Vector3f sky;
  Eigen::Vector3f bounce;
  Eigen::Vector3f backdrop;
  float gain = 1.f;                                     ///< 2^stops of the rig
  Eigen::Matrix3f around = Eigen::Matrix3f::Identity(); ///< columns: axes of the picture of the surroundings
  Eigen::Vector3f floor_key;                            ///< what the shadowed light makes a level white floor send back
  Eigen::Vector3f floor_others;                         ///< what the other lights do

  Eigen::Matrix4f clip_from_world_shadow = Eigen::Matrix4f::Identity();
  Eigen::Matrix4f light_from_world =
      Eigen::Matrix4f::Identity(); ///< rows: the light's right, up, towards-light axes [m]
  int frames_per_map = 1;          ///< consecutive sub-frames that share one shadow map
  int key_taps = KEY_TAPS_MAX;     ///< places of the map that each sub-frame looks up per point
  float shadow_extent = 1.f;       ///< side of the square that the shadow map covers [m]
  float shadow_depth = 1.f;        ///< its reach along the light [m]
  float shadow_spread = 0.f;       ///< tangent of the light's angular radius
  float shadow_share = 1.f;        ///< part of that radius that one sub-frame filters over

  /// Whether the search for blockers reaches as far as the disc of the light does: it stops at a part of the map.
  bool blockers_found() const { return 1.28f * shadow_spread * shadow_depth < BLOCKER_REACH * shadow_extent; }
  static constexpr float BLOCKER_REACH = 0.12f; ///< as in the occlusion pass
};

/// The lights of sub-frame `index` of `count`: the shadowed one moves over its disc from sub-frame to sub-frame.
LightState light_state(const RenderPlan& plan, double camera_azimuth_degrees, int index, int count);

} // namespace wry::render
