#include "sim/geometry/sheet_triangles.h"

namespace wry::geometry {

Result<SheetTriangles> make_sheet_triangles(double width, double depth, int cells_x, int cells_z, SheetSplit split) {
  if (!(width > 0.0) || !(depth > 0.0) || cells_x < 1 || cells_z < 1)
    return make_error(ErrorCode::bad_input, "a sheet of {} x {} m in {} x {} cells: all must be positive", width, depth,
                      cells_x, cells_z);
  SheetTriangles sheet;
  const auto number = [&](int i, int j) { return i * (cells_z + 1) + j; };
  sheet.mesh.vertices.resize(number(cells_x, cells_z) + 1, 3);
  sheet.mesh.body_coordinates.resize(sheet.mesh.vertices.rows(), 2);
  for (int i = 0; i <= cells_x; ++i) {
    for (int j = 0; j <= cells_z; ++j) {
      const double u = static_cast<double>(i) / cells_x, v = static_cast<double>(j) / cells_z;
      sheet.mesh.vertices.row(number(i, j)) << (u - 0.5) * width, 0.0, (v - 0.5) * depth;
      sheet.mesh.body_coordinates.row(number(i, j)) << u, v;
    }
  }
  sheet.triangles.resize(2 * cells_x * cells_z, 3);
  for (int i = 0, row = 0; i < cells_x; ++i) {
    for (int j = 0; j < cells_z; ++j, row += 2) {
      const int a = number(i, j), b = number(i, j + 1), c = number(i + 1, j + 1), d = number(i + 1, j);
      if (split == SheetSplit::parallel || (i + j) % 2 == 0) {
        sheet.triangles.row(row) << a, b, c;
        sheet.triangles.row(row + 1) << a, c, d;
      } else {
        sheet.triangles.row(row) << a, b, d;
        sheet.triangles.row(row + 1) << b, c, d;
      }
    }
  }
  return sheet;
}

} // namespace wry::geometry
