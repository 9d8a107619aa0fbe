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

/// What a drawn picture hides. `clip_from_world` is that of the picture the depths are of.
class HidingPicture {
public:
  HidingPicture(FarthestDepths depths, const Eigen::Matrix4f& clip_from_world, const ImageSize& size);

  /// Whether a grain lies behind everything that is seen of the picture where it stands, by more than its own
  /// thickness, with three pixels of room on all sides: in other sub-frames of the same still picture it cannot be seen
  /// either.
  bool hides(const DrawGrain& grain) const;

private:
  FarthestDepths m_depths;
  Eigen::Matrix3f m_linear; ///< to x, y and distance, before the division
  Eigen::Vector3f m_shift;
  float m_near_distance;
  ImageSize m_size;
};

/// Of points of a picture, x and y [pixels] and distance, those which have fewer than `most` nearer ones in their cell,
/// by number, in order: of a heap about what is seen, so that drawing it first hides most of the rest. `cell`: its side
/// [pixels].
std::vector<std::uint32_t> nearest_in_cells(std::span<const Eigen::Vector3f> places, float cell, std::size_t most);

/// How many of nearest_in_cells() are worth drawing first, where a cell has the area of a grain.
constexpr std::size_t FIRST_MET = 10;

/// Where grains stand in a picture, for nearest_in_cells(), and the side of a square of their mean area there [pixels].
struct GrainPlaces {
  std::vector<Eigen::Vector3f> places;
  float side = 1.f;
};
GrainPlaces grain_places(std::span<const DrawGrain> grains, const Eigen::Matrix4f& clip_from_world,
                         const ImageSize& size);

/// The outlines for a shadow map in two parts: what the light meets first, and, once those are drawn, what they leave
/// to be seen of the rest. The map is the same as if all were drawn: an outline is left out only where all that it
/// covers is nearer already.
class OutlineOrder {
public:
  /// `corners`: four an outline. `clip_from_world`: of the map, without perspective; depth grows away from the light.
  OutlineOrder(std::span<const std::array<float, 3>> corners, const Eigen::Matrix4f& clip_from_world, int map_size);

  /// Those of what is left which have fewer than `most` nearer ones about them; they are left no longer.
  std::vector<std::uint32_t> first_met(std::size_t most);
  /// All of what is left that can be seen. `depth`: the map's, row after row from the bottom.
  std::vector<std::uint32_t> seen_of_the_rest(std::vector<float> depth) const;

private:
  struct Reach {
    float left, bottom, right, top; ///< [texels]
    float nearest;                  ///< depth
  };
  /// A corner [texels, texels, depth] and the two sides from it, the longer first.
  struct Outline {
    Eigen::Vector3f corner, along, across;
  };
  static Reach reach_of(const Outline& outline);
  bool is_hidden(const Outline& outline, const FarthestDepths& depths) const;
  bool is_hidden(const Reach& reach, const FarthestDepths& depths) const;

  std::vector<Outline> m_outlines;
  std::vector<std::uint32_t> m_left; ///< in order
  float m_side = 1.f;                ///< of a square of an outline's mean area [texels]
  int m_map_size;
};

} // namespace wry::render
