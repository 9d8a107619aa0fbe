#pragma once

#include <cstdint>
#include <vector>

#include "sim/base/types.h"

namespace wry::render {

/// Vertices of a surface, split where it has creases, so that each has one normal. Creases are found once, in the rest
/// shape: they do not flicker as the surface moves.
struct SplitSurface {
  Triangles triangles;                ///< indices of split vertices
  std::vector<std::int32_t> original; ///< per split vertex: the vertex it came from
  std::vector<std::int32_t> kept;     ///< per triangle: which one of the given triangles it is
};

/// Splits the vertices of `positions` (n x 3) at edges where the surface bends by more than `crease_degrees`, at open
/// edges' ends and where more than two triangles meet. Triangles whose indices repeat are dropped.
SplitSurface split_at_creases(const Eigen::Ref<const Points>& positions, const Eigen::Ref<const Triangles>& triangles,
                              double crease_degrees);

/// Unit normals of the split vertices of a deformed surface, n x 3: mean of the triangles' normals weighted by their
/// angle at the vertex (Thuermer and Wuethrich 1998). A vertex of degenerate triangles only gets zero.
Points smooth_normals(const SplitSurface& surface, const Eigen::Ref<const Points>& positions);

} // namespace wry::render
