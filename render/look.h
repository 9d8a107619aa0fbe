#pragma once

#include <map>
#include <string>

#include <Eigen/Core>

namespace wry::render {

/// How a surface answers to light. Colours are linear Rec. 709.
struct Look {
  Eigen::Vector3f base_colour = Eigen::Vector3f(.42f, .40f, .38f);
  float roughness = 0.55f; ///< 0.05 ... 1, squared for GGX
  float metallic = 0.0f;   ///< 0 ... 1
  float specular = 0.5f;   ///< 0.5: index 1.5, 4 % at normal incidence
  float wrap = 0.0f;       ///< 0 ... 1: how far light creeps round the terminator (skin, rubber, wax)
  Eigen::Vector3f scatter = Eigen::Vector3f(1.f, .35f, .2f); ///< colour of the light that creeps
  float clearcoat = 0.0f;                                    ///< 0 ... 1: a second, smooth layer (lacquer, wet paint)
  float clearcoat_roughness = 0.1f;                          ///< 0.05 ... 1
  float transparency = 0.0f;     ///< 0 ... 1: how much is seen through it (glass); base_colour tints what is seen
  float colour_variation = 0.0f; ///< 0 ... 0.6: from grain to grain
  float size_variation = 0.0f;   ///< 0 ... 0.9: from grain to grain
};

/// The looks that a shot can name without describing them: clay, rubber, skin, straw, wood, card, metal, ceramic,
/// paint, glass, sand, snow, brick.
const std::map<std::string, Look>& built_in_looks();

} // namespace wry::render
