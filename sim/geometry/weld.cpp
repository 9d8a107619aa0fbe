#include "sim/geometry/weld.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_map>

namespace wry::geometry {

namespace {

using Cell = std::array<std::int64_t, 3>;

struct CellHash {
  std::size_t operator()(const Cell& cell) const {
    std::uint64_t hash = 0x9e3779b97f4a7c15ULL;
    for (const std::int64_t i : cell) {
      hash ^= static_cast<std::uint64_t>(i);
      hash *= 0xff51afd7ed558ccdULL;
      hash ^= hash >> 32;
    }
    return hash;
  }
};

// representative[v] is the vertex that v joins. Exactly equal points: by sorting.
std::vector<std::int32_t> join_equal(const Points& points) {
  std::vector<std::int32_t> order(static_cast<std::size_t>(points.rows()));
  std::iota(order.begin(), order.end(), 0);
  const auto less = [&](std::int32_t a, std::int32_t b) {
    for (int i = 0; i < 3; ++i)
      if (points(a, i) != points(b, i))
        return points(a, i) < points(b, i);
    return a < b;
  };
  std::sort(order.begin(), order.end(), less);
  std::vector<std::int32_t> representative(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && points.row(order[i]) == points.row(order[i - 1]);
    representative[order[i]] = same ? representative[order[i - 1]] : order[i];
  }
  return representative;
}

// Points within a distance: kept vertices are filed in cells of that size, so only 27 cells need a look.
std::vector<std::int32_t> join_near(const Points& points, double tolerance) {
  std::unordered_map<Cell, std::vector<std::int32_t>, CellHash> kept;
  std::vector<std::int32_t> representative(static_cast<std::size_t>(points.rows()));
  for (std::int32_t v = 0; v < points.rows(); ++v) {
    Cell cell{};
    for (int i = 0; i < 3; ++i)
      cell[i] = static_cast<std::int64_t>(std::floor(points(v, i) / tolerance));
    std::int32_t best = v;
    for (int offset = 0; offset < 27; ++offset) {
      const Cell near = {cell[0] + offset % 3 - 1, cell[1] + offset / 3 % 3 - 1, cell[2] + offset / 9 - 1};
      const auto found = kept.find(near);
      if (found == kept.end())
        continue;
      for (const std::int32_t other : found->second)
        if (other < best && (points.row(v) - points.row(other)).norm() <= tolerance)
          best = other;
    }
    representative[v] = best;
    if (best == v)
      kept[cell].push_back(v);
  }
  return representative;
}

// Triangles after joining, without those that collapsed or came twice.
std::vector<std::array<std::int32_t, 3>> kept_triangles(const SurfaceMesh& mesh,
                                                        const std::vector<std::int32_t>& joins) {
  struct Entry {
    std::array<std::int32_t, 3> sorted;
    std::int32_t triangle;
  };
  std::vector<Entry> entries;
  for (std::int32_t t = 0; t < mesh.triangles.rows(); ++t) {
    std::array<std::int32_t, 3> corners = {joins[mesh.triangles(t, 0)], joins[mesh.triangles(t, 1)],
                                           joins[mesh.triangles(t, 2)]};
    std::sort(corners.begin(), corners.end());
    if (corners[0] != corners[1] && corners[1] != corners[2])
      entries.push_back({corners, t});
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.sorted != b.sorted ? a.sorted < b.sorted : a.triangle < b.triangle;
  });
  entries.erase(
      std::unique(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.sorted == b.sorted; }),
      entries.end());
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.triangle < b.triangle; });
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (const Entry& entry : entries)
    triangles.push_back({joins[mesh.triangles(entry.triangle, 0)], joins[mesh.triangles(entry.triangle, 1)],
                         joins[mesh.triangles(entry.triangle, 2)]});
  return triangles;
}

Status check(const SurfaceMesh& mesh, double tolerance) {
  if (!(tolerance >= 0) || !std::isfinite(tolerance))
    return make_error(ErrorCode::bad_input, "the weld tolerance must not be negative; it is {} m", tolerance);
  if (!mesh.vertices.allFinite())
    return make_error(ErrorCode::bad_input, "a mesh with coordinates that are not finite cannot be welded");
  if (mesh.triangles.rows() > 0 && (mesh.triangles.minCoeff() < 0 || mesh.triangles.maxCoeff() >= mesh.vertices.rows()))
    return make_error(ErrorCode::bad_input, "a mesh with indices out of range cannot be welded");
  const double largest = mesh.vertices.rows() > 0 ? mesh.vertices.cwiseAbs().maxCoeff() : 0.0;
  if (tolerance > 0 && largest / tolerance > 4e15)
    return make_error(ErrorCode::bad_input, "the weld tolerance {} m cannot be resolved at coordinates of {} m",
                      tolerance, largest);
  return {};
}

} // namespace

Result<WeldedMesh> weld(const SurfaceMesh& mesh, double tolerance) {
  if (Status status = check(mesh, tolerance); !status)
    return status.error();
  const std::vector<std::int32_t> joins =
      tolerance > 0 ? join_near(mesh.vertices, tolerance) : join_equal(mesh.vertices);
  const std::vector<std::array<std::int32_t, 3>> triangles = kept_triangles(mesh, joins);

  WeldedMesh welded;
  welded.dropped_triangles = mesh.triangles.rows() - static_cast<std::int64_t>(triangles.size());
  std::vector<char> used(joins.size(), 0);
  for (const auto& corners : triangles)
    for (const std::int32_t v : corners)
      used[v] = 1;
  std::vector<std::int32_t> new_index(joins.size(), -1);
  std::vector<std::int32_t> kept;
  for (std::size_t v = 0; v < joins.size(); ++v) {
    if (!used[v])
      continue;
    new_index[v] = static_cast<std::int32_t>(kept.size());
    kept.push_back(static_cast<std::int32_t>(v));
  }
  welded.map.resize(joins.size());
  for (std::size_t v = 0; v < joins.size(); ++v) {
    welded.map[v] = new_index[joins[v]];
    welded.unused_vertices += welded.map[v] < 0;
    welded.merged_vertices += welded.map[v] >= 0 && joins[v] != static_cast<std::int32_t>(v);
  }
  welded.mesh.vertices.resize(static_cast<Eigen::Index>(kept.size()), 3);
  for (std::size_t i = 0; i < kept.size(); ++i)
    welded.mesh.vertices.row(static_cast<Eigen::Index>(i)) = mesh.vertices.row(kept[i]);
  welded.mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      welded.mesh.triangles(static_cast<Eigen::Index>(t), k) = new_index[triangles[t][k]];
  for (const VertexAttribute& attribute : mesh.attributes) {
    VertexAttribute copy{attribute.name, attribute.components, {}};
    const auto width = static_cast<std::size_t>(attribute.components);
    for (const std::int32_t v : kept)
      copy.values.insert(copy.values.end(), attribute.values.begin() + static_cast<std::ptrdiff_t>(v * width),
                         attribute.values.begin() + static_cast<std::ptrdiff_t>((v + 1) * width));
    welded.mesh.attributes.push_back(std::move(copy));
  }
  return welded;
}

} // namespace wry::geometry
