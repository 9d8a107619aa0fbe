#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "render/camera.h"
#include "render/grain_cloud.h"

namespace wry::render {

/// The depths of a picture (near_distance / distance, 0 where nothing is), of which the farthest in a rectangle is
/// found at once: each level holds the least of two by two of the one below.
class FarthestDepths {
public:
  /// `depth`: row after row, from the bottom.
  FarthestDepths(std::vector<float> depth, const ImageSize& size);

  /// The least depth of the pixels [left, right] x [bottom, top], clipped to the picture, or of some more around them.
  float least(int left, int bottom, int right, int top) const;

private:
  struct Level {
    int width = 0, height = 0;
    std::vector<float> least;
  };
  std::vector<Level> m_levels;
};

/// For each grain 1 if it lies behind everything that is seen of the picture where it stands, by more than its own
/// thickness, with three pixels of room on all sides: in other sub-frames of the same still picture it cannot be seen
/// either. `clip_from_world` is that of the picture the depths are of.
std::vector<std::uint8_t> hidden_grains(std::span<const DrawGrain> grains, const Eigen::Matrix4f& clip_from_world,
                                        const FarthestDepths& depths, const ImageSize& size);

/// The outlines for a shadow map in two parts: the nearest to the light, and, once those are drawn, what they leave to
/// be seen of the rest. The map is the same as if all were drawn: an outline is left out only where all that it covers
/// is nearer already.
class OutlineOrder {
public:
  /// `corners`: four an outline. `clip_from_world`: of the map, without perspective; depth grows away from the light.
  OutlineOrder(std::span<const std::array<float, 3>> corners, const Eigen::Matrix4f& clip_from_world, int map_size);

  std::vector<std::uint32_t> nearest(double part);
  /// What is left after nearest(). `depth`: the map's, row after row from the bottom.
  std::vector<std::uint32_t> seen_of_the_rest(std::vector<float> depth) const;

private:
  struct Reach {
    float left, bottom, right, top; ///< [texels]
    float nearest;                  ///< depth
  };
  std::vector<Reach> m_reaches;
  int m_map_size;
  float m_split = 0.f;
};

} // namespace wry::render
