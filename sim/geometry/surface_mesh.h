#pragma once

#include <string>
#include <vector>

#include "sim/base/types.h"

namespace wry::geometry {

/// A named quantity on the vertices of a mesh.
struct VertexAttribute {
  std::string name;
  int components = 1;
  std::vector<double> values; ///< vertices x components, row after row
};

/// Triangles of an artist mesh, a primitive or the boundary of a tet mesh.
struct SurfaceMesh {
  Points vertices;     ///< [m]
  Triangles triangles; ///< counter-clockwise seen from outside
  std::vector<VertexAttribute> attributes;
};

} // namespace wry::geometry
