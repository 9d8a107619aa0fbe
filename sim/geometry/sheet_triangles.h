#pragma once

#include "sim/base/result.h"
#include "sim/geometry/tet_mesh.h"

namespace wry::geometry {

/// How the cells of a sheet are cut into two triangles each.
enum class SheetSplit {
  alternating, ///< diagonals alternate, so that no direction is favoured
  parallel,    ///< all diagonals alike
};

/// A flat sheet of triangles in the x-z plane around the origin, facing +y: what a plate starts from.
struct SheetTriangles {
  TetMesh mesh; ///< vertices and body coordinates (u along x, v along z); no tets
  Triangles triangles;
};

/// `width` along x and `depth` along z [m] in cells_x times cells_z cells.
/// Errors: bad_input for sizes or counts that are not positive.
Result<SheetTriangles> make_sheet_triangles(double width, double depth, int cells_x, int cells_z, SheetSplit split);

} // namespace wry::geometry
