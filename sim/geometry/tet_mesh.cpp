#include "sim/geometry/tet_mesh.h"

#include <algorithm>
#include <array>

namespace wry::geometry {

namespace {

// Faces of a positively oriented tet, outward.
constexpr int FACES[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

struct Face {
  std::array<std::int32_t, 3> sorted;
  std::int32_t tet;
  std::int32_t side;
};

} // namespace

Triangles boundary_triangles(const TetMesh& mesh) {
  std::vector<Face> faces;
  faces.reserve(static_cast<std::size_t>(mesh.tets.rows()) * 4);
  for (std::int32_t tet = 0; tet < mesh.tets.rows(); ++tet) {
    for (std::int32_t side = 0; side < 4; ++side) {
      std::array<std::int32_t, 3> corners{};
      for (int k = 0; k < 3; ++k)
        corners[k] = mesh.tets(tet, FACES[side][k]);
      std::sort(corners.begin(), corners.end());
      faces.push_back({corners, tet, side});
    }
  }
  std::vector<std::size_t> order(faces.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return faces[a].sorted != faces[b].sorted ? faces[a].sorted < faces[b].sorted : a < b;
  });
  std::vector<char> is_boundary(faces.size(), 1);
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (faces[order[i]].sorted == faces[order[i - 1]].sorted)
      is_boundary[order[i]] = is_boundary[order[i - 1]] = 0;
  }
  const auto count = std::count(is_boundary.begin(), is_boundary.end(), 1);
  Triangles triangles(count, 3);
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (!is_boundary[i])
      continue;
    for (int k = 0; k < 3; ++k)
      triangles(row, k) = mesh.tets(faces[i].tet, FACES[faces[i].side][k]);
    ++row;
  }
  return triangles;
}

} // namespace wry::geometry
