#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/geometry/surface_mesh.h"
#include "sim/geometry/tet_mesh.h"

namespace wry::scene {

/// Where formulas and regions are evaluated: points of a body at rest, with what they carry.
struct RestPoints {
  Points positions; ///< in the shot's world, after the body's placement [m]
  /// points x 2: u, v; empty where the body has none.
  Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor> body_coordinates;
  std::vector<geometry::VertexAttribute> attributes;
};

/// The vertices of a tet mesh.
RestPoints rest_points(const geometry::TetMesh& mesh);

/// Names by which formulas call the components of attributes, in order: "heat", or "colour_x", "colour_y", "colour_z"
/// (and
/// "_w"; with more components "_0", "_1", ...).
std::vector<std::string> component_names(std::span<const geometry::VertexAttribute> attributes);

} // namespace wry::scene
