#pragma once

#include <vector>

#include "sim/geometry/tet_mesh.h"

namespace wry::fem {

/// A mesh renumbered so that neighbours are near in memory, and the way back.
struct OrderedMesh {
  geometry::TetMesh mesh;                   ///< vertices and tets only
  std::vector<std::int32_t> vertex_of_node; ///< new -> old
  std::vector<std::int32_t> node_of_vertex; ///< old -> new
  std::vector<std::int32_t> tet_of_element; ///< new -> old; of a plate, its triangle
};

/// Reverse Cuthill-McKee order of the vertices, tets by their lowest one. Deterministic.
OrderedMesh order_for_locality(const geometry::TetMesh& mesh);

/// The same for any elements of `per_element` vertices each, which are renumbered and sorted in place. The mesh has
/// vertices only.
OrderedMesh order_for_locality(const Points& vertices, int per_element, std::vector<std::int32_t>& elements);

} // namespace wry::fem
