#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <vector>

#include "render/image.h"
#include "render/lights.h"
#include "sim/base/result.h"

namespace wry::render {

/// Rows and columns of one level of the mirrored surroundings.
constexpr int MIRROR_WIDTH = 128;
constexpr int MIRROR_HEIGHT = 64;
/// From sharp to matt; the level of a roughness is roughness * (MIRROR_LEVELS - 1).
constexpr int MIRROR_LEVELS = 6;

/// Light from all around, ready for the shaders. Directions are (x: right, y: up, z: towards azimuth 0).
struct EnvironmentMaps {
  /// Spherical harmonics up to degree 2 of what a white matt surface sends back (Ramamoorthi and Hanrahan 2001).
  std::array<Eigen::Vector3f, 9> matt;
  /// The surroundings as surfaces of growing roughness mirror them: levels one below the other, equirectangular.
  std::vector<std::array<float, 4>> mirrored;
};

/// `below`: light that comes from the floor, in place of what the picture has below the horizon; absent: the picture's.
EnvironmentMaps make_environment_maps(const LinearImage& surroundings, const std::optional<Eigen::Vector3f>& below);

/// What a white matt surface facing `direction` sends back.
Eigen::Vector3f matt_light(const EnvironmentMaps& maps, const Eigen::Vector3f& direction);

/// Sun from the upper left, blue sky with a bright horizon, outdoors.
Rig day_rig();

/// A rig of an equirectangular picture of the surroundings. Its sun, if it has one (a spot far brighter than the rest),
/// becomes a light that casts shadows and leaves the picture. Errors: bad_input for a picture that is not twice as wide
/// as high, has no light, or has values that are not finite or negative.
Result<Rig> image_rig(const LinearImage& surroundings);

/// Reads Radiance .hdr or OpenEXR, linear. Errors: missing_input; bad_input for what is neither, damaged or too large.
Result<LinearImage> read_light_image(const std::filesystem::path& path);

} // namespace wry::render
