#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "render/grain_cloud.h"

namespace wry::render {

/// Where grains are seen from: a place [m], or from far away along a unit direction towards the viewer.
struct ViewPoint {
  enum class Kind { place, direction };
  Kind kind = Kind::place;
  Eigen::Vector3f vector = Eigen::Vector3f::UnitZ();

  Eigen::Vector3f towards(const Eigen::Vector3f& from) const {
    return kind == Kind::place ? Eigen::Vector3f(vector - from) : vector;
  }
};

/// One vertex of a grain as the graphics library reads it.
struct GrainVertex {
  std::array<float, 3> position; ///< [m]
  std::uint32_t normal;          ///< on the octahedron, two times 16 bits
  std::uint32_t word;            ///< see surface_word()
};

/// Triangles with an index list of their own.
struct GrainTriangles {
  std::vector<GrainVertex> vertices;
  std::vector<std::uint32_t> indices;
};

constexpr int BOX_VERTICES = 7;
constexpr int BOX_INDICES = 18;
constexpr int OUTLINE_VERTICES = 4;
constexpr int OUTLINE_INDICES = 6;

/// The three faces of a box that can be seen at all: its nearest corner and the six about it. The normal of a face is
/// that of the last vertex of its triangles. `seconds`: how far along their velocity the grains have moved.
void append_boxes(std::span<const DrawGrain> grains, const ViewPoint& from, float seconds,
                  std::vector<GrainVertex>& out);
/// The pattern of append_boxes() for one box, from vertex 0.
std::array<std::uint32_t, BOX_INDICES> box_indices();

/// About what a box covers, as a flat parallelogram through its middle along its two longest sides, of the same area:
/// for shadows, which then need no bias against themselves.
void append_outlines(std::span<const DrawGrain> grains, const ViewPoint& from, float seconds,
                     std::vector<std::array<float, 3>>& out);
std::array<std::uint32_t, OUTLINE_INDICES> outline_indices();

/// The side of a cylinder along z that faces the viewer, of `segments` strips, and its nearer end; hollow for straws.
void append_cylinders(std::span<const DrawGrain> grains, GrainShape shape, int segments, const ViewPoint& from,
                      float seconds, GrainTriangles& out);
/// The half of an ellipsoid that faces the viewer: rings of 2 * `segments` points.
void append_spheres(std::span<const DrawGrain> grains, int segments, const ViewPoint& from, float seconds,
                    GrainTriangles& out);

/// Vertices of one grain of append_cylinders() or append_spheres().
std::size_t round_vertices(GrainShape shape, int segments);

/// How finely a round grain of `pixels` across is cut; 0: a box will do.
int round_segments(float pixels);

/// A unit vector on the octahedron (Meyer et al. 2010), two times 16 bits.
std::uint32_t octahedral_word(const Eigen::Vector3f& normal);

} // namespace wry::render
