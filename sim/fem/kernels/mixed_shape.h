#pragma once

#include <utility>

#include "sim/fem/kernels/mixed_batch.h"
#include "sim/fem/kernels/tensors.h"

/// Elements whose positions may be interpolated by other functions than their rotations, as types:
///   CORNERS carry rotations, linear between them; POINTS quadrature points; DIM 3 for tets, 2 for plates;
///   QUADRATIC: midpoints of the edges carry positions besides;
///   NEAR, FAR: barycentric coordinates of a point, near the corner of its number.
namespace wry::fem::WRY_ISA {

struct Tet10Shape {
  static constexpr int CORNERS = 4, POINTS = 4, DIM = 3;
  static constexpr bool QUADRATIC = true;
  static constexpr double NEAR = 0.5854101966249685, FAR = 0.1381966011250105;
};
struct Tet4OnePointShape {
  static constexpr int CORNERS = 4, POINTS = 1, DIM = 3;
  static constexpr bool QUADRATIC = false;
  static constexpr double NEAR = 0.25, FAR = 0.25;
};
struct Plate3Shape {
  static constexpr int CORNERS = 3, POINTS = 3, DIM = 2;
  static constexpr bool QUADRATIC = false;
  static constexpr double NEAR = 2.0 / 3.0, FAR = 1.0 / 6.0;
};
struct Plate6Shape {
  static constexpr int CORNERS = 3, POINTS = 3, DIM = 2;
  static constexpr bool QUADRATIC = true;
  static constexpr double NEAR = 2.0 / 3.0, FAR = 1.0 / 6.0;
};

template <class Shape>
inline constexpr int NODES = Shape::QUADRATIC ? Shape::CORNERS*(Shape::CORNERS + 1) / 2 : Shape::CORNERS;

/// phi of a corner at a point.
template <class Shape> constexpr double barycentric(int corner, int point) {
  return corner == point ? Shape::NEAR : Shape::FAR;
}

/// The corners of an edge, whose midpoint is node CORNERS + edge.
struct EdgeCorners {
  int first = 0, second = 0;
};
template <class Shape> constexpr EdgeCorners edge_corners(int edge) {
  for (int i = 0; i < Shape::CORNERS; ++i) {
    const int count = Shape::CORNERS - 1 - i;
    if (edge < count)
      return {i, i + 1 + edge};
    edge -= count;
  }
  return {};
}

/// Whether the gradient of a node's shape function has a part along that of a corner's linear function.
template <class Shape> constexpr bool has_share(int node, int corner) {
  if (node < Shape::CORNERS)
    return node == corner;
  const EdgeCorners edge = edge_corners<Shape>(node - Shape::CORNERS);
  return corner == edge.first || corner == edge.second;
}

/// The gradient of a node's shape function at a point is the sum of share[point][node][corner] times the gradient of
/// the corner's linear function.
template <class Shape> struct GradientShares {
  double share[Shape::POINTS][NODES<Shape>][Shape::CORNERS] = {};

  constexpr GradientShares() {
    for (int p = 0; p < Shape::POINTS; ++p) {
      for (int k = 0; k < Shape::CORNERS; ++k)
        share[p][k][k] = Shape::QUADRATIC ? 4.0 * barycentric<Shape>(k, p) - 1.0 : 1.0;
      for (int k = Shape::CORNERS; k < NODES<Shape>; ++k) {
        const EdgeCorners edge = edge_corners<Shape>(k - Shape::CORNERS);
        share[p][k][edge.first] = 4.0 * barycentric<Shape>(edge.second, p);
        share[p][k][edge.second] = 4.0 * barycentric<Shape>(edge.first, p);
      }
    }
  }
};
template <class Shape> inline constexpr GradientShares<Shape> SHARES{};

/// body(0), body(1), .. with numbers known to the compiler.
template <int COUNT, class Body> WRY_INLINE void unroll(const Body& body) {
  [&]<int... I>(std::integer_sequence<int, I...>) {
    (body(std::integral_constant<int, I>()), ...);
  }
  (std::make_integer_sequence<int, COUNT>());
}

} // namespace wry::fem::WRY_ISA
