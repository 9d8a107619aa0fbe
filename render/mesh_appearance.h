#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "render/image.h"

namespace wry::render {

/// A material as an artist's file gives it. Colours are linear Rec. 709.
struct ArtistMaterial {
  std::string name;
  Eigen::Vector3f base_colour = Eigen::Vector3f::Constant(.6f);
  float roughness = 0.6f;
  float metallic = 0.0f;
  int texture = -1; ///< of MeshAppearance::textures, multiplies the base colour; -1: none
};

/// How an artist's mesh wants to look: per triangle a material, and per corner where it lies on the material's picture
/// and which colour it was painted with.
struct MeshAppearance {
  std::vector<ArtistMaterial> materials;
  std::vector<Image> textures;                    ///< sRGB, rows from the top, as the file's coordinates count them
  std::vector<std::int32_t> material_of_triangle; ///< a row of `materials`
  std::vector<std::array<float, 2>> corner_uv;    ///< three a triangle; v counts down from the top; empty: none
  std::vector<Eigen::Vector3f> corner_colour;     ///< three a triangle, linear; empty: unpainted
};

} // namespace wry::render
