#pragma once

#include <array>

#include "sim/base/result.h"
#include "sim/geometry/primitives.h"
#include "sim/geometry/tet_mesh.h"

namespace wry::geometry {

/// How each hexahedral cell of a structured mesh is cut into tets. All of them conform from cell to cell.
enum class CellSplit {
  five, ///< one regular and four corner tets, mirrored from cell to cell; mirror-symmetric where the count is even
  kuhn, ///< six tets around the same diagonal in every cell: favours that diagonal. For reproducing published numbers
  kuhn_mirrored, ///< six tets, mirrored from cell to cell along each axis: symmetric where the counts are even
  kuhn_outward,  ///< six tets around the diagonal that points away from the block's middle; best for round sections
  twelve,        ///< from the cell's centre to two triangles per face, which alternate
  twenty_four,   ///< from the cell's centre to four triangles per face: has all symmetries of the cell itself
};

/// How many cells, and how they are cut.
struct BlockCells {
  std::array<int, 3> cells = {1, 1, 1}; ///< along x, y, z; a sheet's layers are the number along its axis
  CellSplit split = CellSplit::five;
};

/// The split that suits a section: `five` for boxes, `kuhn_outward` for round ones (whose corner cells would be flat
/// otherwise).
CellSplit default_split(Section section);

/// Positively oriented, conforming tets that fill the block, with body coordinates u, v. Vertices of the cells come
/// first, x fastest, then the centres that the split needs. Errors: bad_input for sizes or counts that are not
/// positive, for a round section with unequal or odd counts across, and for more than 1e8 tets.
Result<TetMesh> make_block_tets(const Block& block, const BlockCells& cells);

/// As above with cells_for_edge(block, target_edge) and default_split.
Result<TetMesh> make_block_tets(const Block& block, double target_edge);

} // namespace wry::geometry
