#pragma once

#include <vector>

#include "sim/base/result.h"
#include "sim/geometry/surface_mesh.h"

namespace wry::geometry {

/// How a surface is divided anew.
struct RemeshSettings {
  double edge = 0;           ///< target edge [m]
  double finest = 1;         ///< edges may shrink to this share of the target where the surface bends; 1: uniform
  double turn = 90;          ///< angle that one edge may span where the surface bends [degrees]
  double feature_angle = 50; ///< edges sharper than this are kept as lines [degrees]
  int passes = 10;           ///< of splitting, collapsing, flipping and smoothing
};

/// Divides a closed manifold surface into nearly equilateral triangles of the target edge (Botsch and Kobbelt 2004):
/// long edges are split, short ones collapsed, valences evened by flips, vertices smoothed along the surface and put
/// back on it. Sharp edges and corners stay. The result is closed and manifold, lies on the surface at its vertices,
/// carries no attributes, and does not depend on the number of threads. Errors: bad_input if the surface is open, not
/// manifold or empty, or the edge is not positive.
Result<SurfaceMesh> remesh(const SurfaceMesh& surface, const RemeshSettings& settings);

/// The same at a uniform edge.
Result<SurfaceMesh> remesh(const SurfaceMesh& surface, double edge);

} // namespace wry::geometry
