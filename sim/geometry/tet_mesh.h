#pragma once

#include <vector>

#include "sim/geometry/surface_mesh.h"

namespace wry::geometry {

/// Linear tetrahedra in their rest shape.
struct TetMesh {
  Points vertices; ///< rest positions [m]
  Tets tets;       ///< positively oriented
  /// vertices x 2: a body's own coordinates u, v in [0, 1] where the mesh has them (rods, sheets), else empty.
  Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor> body_coordinates;
  std::vector<VertexAttribute> attributes;
};

/// Triangles that belong to one tet only, outward, in order of tets. Indices are those of the tet mesh.
Triangles boundary_triangles(const TetMesh& mesh);

} // namespace wry::geometry
