#include "sim/geometry/mesh_checks.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include "sim/geometry/mesh_checks_edges.h"

namespace wry::geometry {

namespace {

constexpr std::size_t MAX_EXAMPLES = 8;

void add(MeshFlaw& flaw, std::int32_t index) {
  if (++flaw.count <= static_cast<std::int64_t>(MAX_EXAMPLES))
    flaw.examples.push_back(index);
}

void inspect_vertices(const SurfaceMesh& mesh, const std::vector<char>& use, MeshReport& report) {
  std::vector<char> used(static_cast<std::size_t>(mesh.vertices.rows()), 0);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t)
    if (use[t])
      for (int k = 0; k < 3; ++k)
        used[mesh.triangles(t, k)] = 1;
  bool first = true;
  for (std::int32_t v = 0; v < mesh.vertices.rows(); ++v) {
    const Vec3 point = mesh.vertices.row(v).transpose();
    if (!point.allFinite()) {
      add(report.non_finite_vertices, v);
      continue;
    }
    if (!used[v]) {
      ++report.unused_vertices;
      continue;
    }
    report.lower = first ? point : report.lower.cwiseMin(point);
    report.upper = first ? point : report.upper.cwiseMax(point);
    first = false;
  }
}

void inspect_triangles(const SurfaceMesh& mesh, const std::vector<char>& use, MeshReport& report) {
  const Vec3 middle = 0.5 * (report.lower + report.upper);
  for (std::int32_t t = 0; t < mesh.triangles.rows(); ++t) {
    const auto corners = mesh.triangles.row(t);
    if (!use[t]) {
      const bool in_range = corners.minCoeff() >= 0 && corners.maxCoeff() < mesh.vertices.rows();
      add(in_range ? report.repeated_corners : report.bad_indices, t);
      continue;
    }
    const Vec3 a = mesh.vertices.row(corners[0]).transpose() - middle;
    const Vec3 b = mesh.vertices.row(corners[1]).transpose() - middle;
    const Vec3 c = mesh.vertices.row(corners[2]).transpose() - middle;
    const double doubled_area = (b - a).cross(c - a).norm();
    const double longest = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    if (!std::isfinite(doubled_area))
      continue;
    if (!(doubled_area > 1e-12 * longest))
      add(report.zero_area_triangles, t);
    report.area += 0.5 * doubled_area;
    report.volume += a.cross(b).dot(c) / 6;
  }
}

void inspect_duplicates(const SurfaceMesh& mesh, const std::vector<char>& use, MeshReport& report) {
  std::vector<std::array<std::int32_t, 4>> sorted;
  for (std::int32_t t = 0; t < mesh.triangles.rows(); ++t) {
    if (!use[t])
      continue;
    std::array<std::int32_t, 4> entry = {mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2), t};
    std::sort(entry.begin(), entry.begin() + 3);
    sorted.push_back(entry);
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::int32_t> duplicates;
  for (std::size_t i = 1; i < sorted.size(); ++i)
    if (std::equal(sorted[i].begin(), sorted[i].begin() + 3, sorted[i - 1].begin()))
      duplicates.push_back(sorted[i][3]);
  std::sort(duplicates.begin(), duplicates.end());
  for (const std::int32_t t : duplicates)
    add(report.duplicate_triangles, t);
}

// A directed edge of one triangle only.
struct BoundaryEdge {
  std::int32_t from;
  std::int32_t to;
  bool taken = false;
};

BoundaryLoop follow_loop(const SurfaceMesh& mesh, std::vector<BoundaryEdge>& edges, std::size_t start) {
  BoundaryLoop loop;
  loop.first_vertex = edges[start].from;
  Vec3 lower = mesh.vertices.row(loop.first_vertex).transpose();
  Vec3 upper = lower;
  for (std::size_t at = start; at < edges.size();) {
    edges[at].taken = true;
    ++loop.edges;
    const Vec3 to = mesh.vertices.row(edges[at].to).transpose();
    loop.length += (to - mesh.vertices.row(edges[at].from).transpose()).norm();
    lower = lower.cwiseMin(to);
    upper = upper.cwiseMax(to);
    const std::int32_t end = edges[at].to;
    if (end == loop.first_vertex)
      break;
    const auto next = std::lower_bound(edges.begin(), edges.end(), end,
                                       [](const BoundaryEdge& edge, std::int32_t v) { return edge.from < v; });
    at = static_cast<std::size_t>(next - edges.begin());
    while (at < edges.size() && edges[at].from == end && edges[at].taken)
      ++at;
    if (at < edges.size() && edges[at].from != end)
      break; // triangles that disagree leave chains instead of loops
  }
  loop.centre = 0.5 * (lower + upper);
  loop.extent = upper - lower;
  return loop;
}

void inspect_boundary(const SurfaceMesh& mesh, std::vector<BoundaryEdge>& edges, MeshReport& report) {
  report.boundary_edges = static_cast<std::int64_t>(edges.size());
  std::sort(edges.begin(), edges.end(), [](const BoundaryEdge& a, const BoundaryEdge& b) {
    return a.from != b.from ? a.from < b.from : a.to < b.to;
  });
  std::vector<BoundaryLoop> loops;
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (!edges[i].taken)
      loops.push_back(follow_loop(mesh, edges, i));
  report.boundary_loops = static_cast<std::int64_t>(loops.size());
  std::stable_sort(loops.begin(), loops.end(),
                   [](const BoundaryLoop& a, const BoundaryLoop& b) { return a.length > b.length; });
  loops.resize(std::min(loops.size(), MAX_EXAMPLES));
  report.longest_loops = std::move(loops);
}

void inspect_edges(const SurfaceMesh& mesh, const std::vector<char>& use, MeshReport& report) {
  const std::vector<TriangleSide> sides = sorted_sides(mesh.triangles, use);
  DisjointSets parts(use.size());
  DisjointSets fans(use.size() * 3);
  std::vector<BoundaryEdge> boundary;
  for_each_edge(sides, [&](std::size_t first, std::size_t last) {
    const TriangleSide& side = sides[first];
    if (last - first == 1)
      boundary.push_back({side.forward ? side.low : side.high, side.forward ? side.high : side.low});
    else if (last - first > 2)
      add(report.nonmanifold_edges, side.low);
    else if (side.forward == sides[first + 1].forward)
      add(report.inconsistent_edges, side.low);
    for (std::size_t i = first + 1; i < last; ++i) {
      parts.join(side.triangle, sides[i].triangle);
      const auto corner_at = [](const TriangleSide& s, bool low) {
        return 3 * s.triangle + (s.forward == low ? s.corner : (s.corner + 1) % 3);
      };
      fans.join(corner_at(side, true), corner_at(sides[i], true));
      fans.join(corner_at(side, false), corner_at(sides[i], false));
    }
  });
  inspect_boundary(mesh, boundary, report);

  std::vector<std::int32_t> fan_of(static_cast<std::size_t>(mesh.vertices.rows()), -1);
  std::vector<char> is_split(fan_of.size(), 0);
  for (std::int32_t t = 0; t < mesh.triangles.rows(); ++t) {
    if (!use[t])
      continue;
    report.components += parts.find(t) == t;
    for (std::int32_t k = 0; k < 3; ++k) {
      const std::int32_t v = mesh.triangles(t, k);
      const std::int32_t fan = fans.find(3 * t + k);
      if (fan_of[v] < 0)
        fan_of[v] = fan;
      is_split[v] |= static_cast<char>(fan_of[v] != fan);
    }
  }
  for (std::int32_t v = 0; v < mesh.vertices.rows(); ++v)
    if (is_split[v])
      add(report.nonmanifold_vertices, v);
}

std::string place(const SurfaceMesh& mesh, std::int32_t vertex) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", mesh.vertices(vertex, 0), mesh.vertices(vertex, 1),
                     mesh.vertices(vertex, 2));
}

} // namespace

MeshReport inspect_mesh(const SurfaceMesh& mesh) {
  MeshReport report;
  report.vertices = mesh.vertices.rows();
  report.triangles = mesh.triangles.rows();
  const std::vector<char> use = usable_triangles(mesh.triangles, mesh.vertices.rows());
  inspect_vertices(mesh, use, report);
  inspect_triangles(mesh, use, report);
  inspect_duplicates(mesh, use, report);
  inspect_edges(mesh, use, report);
  return report;
}

Status check_valid(const SurfaceMesh& mesh, const MeshReport& report, const std::string& name) {
  if (report.triangles == 0)
    return make_error(ErrorCode::bad_input, "{} has no triangles", name);
  if (report.non_finite_vertices.count > 0)
    return make_error(ErrorCode::bad_input, "{}: {} of {} vertices are not finite numbers, the first is vertex {}",
                      name, report.non_finite_vertices.count, report.vertices, report.non_finite_vertices.examples[0]);
  if (report.bad_indices.count > 0) {
    const std::int32_t t = report.bad_indices.examples[0];
    return make_error(ErrorCode::bad_input, "{}: triangle {} names vertices {}, {}, {}, but there are only 0..{}", name,
                      t, mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2), report.vertices - 1);
  }
  if (report.repeated_corners.count > 0)
    return make_error(ErrorCode::bad_input, "{}: {} of {} triangles name a vertex twice, the first is triangle {}",
                      name, report.repeated_corners.count, report.triangles, report.repeated_corners.examples[0]);
  return {};
}

Status check_closed(const MeshReport& report, const std::string& name) {
  if (report.is_closed())
    return {};
  if (report.longest_loops.empty())
    return make_error(ErrorCode::bad_input, "{} has no usable triangles", name);
  const BoundaryLoop& loop = report.longest_loops[0];
  return make_error(
      ErrorCode::bad_input,
      "{} is not closed: {} hole{}, the longest has {} edges, {:.4g} m around, at ({:.4g}, {:.4g}, {:.4g}), "
      "extent {:.3g} x {:.3g} x {:.3g} m; fill it in the modelling program",
      name, report.boundary_loops, report.boundary_loops == 1 ? "" : "s", loop.edges, loop.length, loop.centre.x(),
      loop.centre.y(), loop.centre.z(), loop.extent.x(), loop.extent.y(), loop.extent.z());
}

Status check_manifold(const SurfaceMesh& mesh, const MeshReport& report, const std::string& name) {
  if (report.nonmanifold_edges.count > 0)
    return make_error(
        ErrorCode::bad_input,
        "{}: {} edges belong to more than two triangles, the first is at vertex {} {}; remove inner faces", name,
        report.nonmanifold_edges.count, report.nonmanifold_edges.examples[0],
        place(mesh, report.nonmanifold_edges.examples[0]));
  if (report.nonmanifold_vertices.count > 0)
    return make_error(
        ErrorCode::bad_input,
        "{}: {} vertices join parts that touch at a point only, the first is vertex {} {}; separate the parts", name,
        report.nonmanifold_vertices.count, report.nonmanifold_vertices.examples[0],
        place(mesh, report.nonmanifold_vertices.examples[0]));
  return {};
}

} // namespace wry::geometry
