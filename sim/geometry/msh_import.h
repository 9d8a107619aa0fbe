#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/base/result.h"
#include "sim/geometry/tet_mesh.h"

namespace wry::geometry {

/// The tets of a Gmsh file and what was done to them.
struct MshMesh {
  TetMesh mesh;                       ///< in the units of the file
  std::int64_t turned_tets = 0;       ///< were inverted in the file
  std::int64_t unused_vertices = 0;   ///< belonged to no tet, left out
  std::int64_t second_order_tets = 0; ///< came with 10 nodes; their corners were taken
};

/// Reads tets from the text of a Gmsh .msh file, version 2.2 or 4.1, ASCII. Points, lines and faces are passed over;
/// other solids than tets are refused. Vertices keep the order of the file. Memory stays in proportion to the text,
/// whatever its counts claim. Errors: bad_input, naming the line: another version, binary, early end, bad or repeated
/// numbers, coordinates that are not finite, tets that name missing vertices or one twice, tets without volume, faces
/// shared by more than two tets, no tets.
Result<MshMesh> parse_msh(std::string_view text);

/// Reads a file with parse_msh; messages begin with the path. Errors also: missing_input, io.
Result<MshMesh> read_msh(const std::string& path);

/// As read_msh, for those who only want the tets.
Result<TetMesh> import_tets(const std::string& path);

} // namespace wry::geometry
