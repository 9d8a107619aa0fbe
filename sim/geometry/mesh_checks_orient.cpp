#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include <Eigen/Geometry>

#include "sim/geometry/mesh_checks.h"
#include "sim/geometry/mesh_checks_edges.h"

namespace wry::geometry {

namespace {

// Beyond this many triangle visits, which part lies inside which is not worked out.
constexpr double MAX_NESTING_WORK = 2e9;

// Triangles joined by two-sided edges.
struct Part {
  std::vector<std::int32_t> triangles;
  std::int64_t against = 0; // triangles that disagreed with the first one
  bool closed = true;
  double volume = 0; // after they agree [m^3]
  Vec3 lower = Vec3::Zero();
  Vec3 upper = Vec3::Zero();
  bool turn = false;

  bool agreed() const { return against == 0 || against == static_cast<std::int64_t>(triangles.size()); }
};

struct Neighbour {
  std::int32_t triangle = -1;
  bool agrees = true;
};

using Neighbours = std::vector<std::array<Neighbour, 3>>;

Neighbours two_sided_neighbours(const Triangles& triangles, const std::vector<char>& use, std::vector<char>& has_rim) {
  Neighbours neighbours(use.size());
  const std::vector<TriangleSide> sides = sorted_sides(triangles, use);
  for_each_edge(sides, [&](std::size_t first, std::size_t last) {
    if (last - first != 2) {
      for (std::size_t i = first; i < last; ++i)
        has_rim[sides[i].triangle] |= static_cast<char>(last - first == 1);
      return;
    }
    const TriangleSide& a = sides[first];
    const TriangleSide& b = sides[first + 1];
    neighbours[a.triangle][a.corner] = {b.triangle, a.forward != b.forward};
    neighbours[b.triangle][b.corner] = {a.triangle, a.forward != b.forward};
  });
  return neighbours;
}

Vec3 corner(const SurfaceMesh& mesh, std::int32_t triangle, int k) {
  return mesh.vertices.row(mesh.triangles(triangle, k)).transpose();
}

// Collects the part around `seed`; flip[t] says that t disagrees with it.
Result<Part> collect_part(const SurfaceMesh& mesh, const Neighbours& neighbours, const std::vector<char>& has_rim,
                          std::int32_t seed, std::vector<char>& visited, std::vector<char>& flip) {
  Part part;
  part.triangles = {seed};
  visited[seed] = 1;
  for (std::size_t i = 0; i < part.triangles.size(); ++i) {
    const std::int32_t t = part.triangles[i];
    part.against += flip[t];
    part.closed = part.closed && !has_rim[t];
    for (const Neighbour& next : neighbours[t]) {
      if (next.triangle < 0)
        continue;
      const char wanted = static_cast<char>(next.agrees ? flip[t] : !flip[t]);
      if (visited[next.triangle] && flip[next.triangle] != wanted) {
        const Vec3 at = corner(mesh, t, 0);
        return make_error(
            ErrorCode::bad_input,
            "the surface has only one side (a Moebius strip): triangles {} and {} cannot agree, at ({:.6g}, "
            "{:.6g}, {:.6g})",
            t, next.triangle, at.x(), at.y(), at.z());
      }
      if (!visited[next.triangle]) {
        visited[next.triangle] = 1;
        flip[next.triangle] = wanted;
        part.triangles.push_back(next.triangle);
      }
    }
  }
  return part;
}

void measure_part(const SurfaceMesh& mesh, const std::vector<char>& flip, Part& part) {
  part.lower = part.upper = corner(mesh, part.triangles[0], 0);
  for (const std::int32_t t : part.triangles) {
    for (int k = 0; k < 3; ++k) {
      part.lower = part.lower.cwiseMin(corner(mesh, t, k));
      part.upper = part.upper.cwiseMax(corner(mesh, t, k));
    }
  }
  const Vec3 middle = 0.5 * (part.lower + part.upper);
  for (const std::int32_t t : part.triangles) {
    const double volume =
        (corner(mesh, t, 0) - middle).cross(corner(mesh, t, 1) - middle).dot(corner(mesh, t, 2) - middle) / 6;
    part.volume += flip[t] ? -volume : volume;
  }
}

// Solid angle of the part seen from a point over 4 pi, with its triangles made to agree: +-1 inside, 0 outside
// (van Oosterom & Strackee 1983).
double winding_number(const SurfaceMesh& mesh, const Part& part, const std::vector<char>& flip, const Vec3& point) {
  double sum = 0;
  for (const std::int32_t t : part.triangles) {
    const Vec3 a = corner(mesh, t, 0) - point;
    const Vec3 b = corner(mesh, t, 1) - point;
    const Vec3 c = corner(mesh, t, 2) - point;
    const double la = a.norm();
    const double lb = b.norm();
    const double lc = c.norm();
    const double angle =
        2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    sum += flip[t] ? -angle : angle;
  }
  return sum / (4 * std::numbers::pi);
}

bool box_inside(const Part& inner, const Part& outer) {
  return (inner.lower.array() >= outer.lower.array()).all() && (inner.upper.array() <= outer.upper.array()).all();
}

// outermost[i] is the part around part i that lies inside no other, or i itself.
std::vector<std::size_t> find_outermost(const SurfaceMesh& mesh, const std::vector<Part>& parts,
                                        const std::vector<char>& flip, OrientReport& report) {
  std::vector<std::size_t> outermost(parts.size());
  std::iota(outermost.begin(), outermost.end(), 0);
  double work = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (std::size_t j = 0; j < parts.size(); ++j) {
      if (i == j || !parts[i].closed || !parts[j].closed || !box_inside(parts[i], parts[j]))
        continue;
      // Equal boxes: only a larger volume may contain.
      if (std::abs(parts[j].volume) <= std::abs(parts[i].volume))
        continue;
      work += static_cast<double>(parts[j].triangles.size());
      if (work > MAX_NESTING_WORK) {
        report.nesting_checked = false;
        std::iota(outermost.begin(), outermost.end(), 0);
        return outermost;
      }
      const bool inside = std::abs(winding_number(mesh, parts[j], flip, corner(mesh, parts[i].triangles[0], 0))) > 0.5;
      const double so_far = outermost[i] == i ? 0 : std::abs(parts[outermost[i]].volume);
      if (inside && std::abs(parts[j].volume) > so_far)
        outermost[i] = j;
    }
  }
  return outermost;
}

void decide_turns(std::vector<Part>& parts, const std::vector<std::size_t>& outermost, OrientReport& report) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    Part& part = parts[i];
    const Part& outer = parts[outermost[i]];
    if (!part.closed) {
      part.turn = 2 * part.against > static_cast<std::int64_t>(part.triangles.size());
    } else if (outermost[i] == i || !part.agreed()) {
      part.turn = part.volume < 0;
    } else {
      part.turn = outer.volume < 0 && outer.agreed();
      const bool is_inward = part.turn ? part.volume > 0 : part.volume < 0;
      report.cavities += is_inward;
    }
  }
}

} // namespace

Result<OrientReport> orient_outward(SurfaceMesh& mesh) {
  const std::vector<char> use = usable_triangles(mesh.triangles, mesh.vertices.rows());
  if (std::find(use.begin(), use.end(), 0) != use.end() || !mesh.vertices.allFinite())
    return make_error(ErrorCode::bad_input, "a mesh with bad indices, repeated corners or NaN cannot be oriented");
  std::vector<char> has_rim(use.size(), 0);
  const Neighbours neighbours = two_sided_neighbours(mesh.triangles, use, has_rim);
  std::vector<char> visited(use.size(), 0);
  std::vector<char> flip(use.size(), 0);
  std::vector<Part> parts;
  for (std::int32_t t = 0; t < mesh.triangles.rows(); ++t) {
    if (visited[t])
      continue;
    Result<Part> part = collect_part(mesh, neighbours, has_rim, t, visited, flip);
    if (!part)
      return std::move(part).error();
    measure_part(mesh, flip, *part);
    parts.push_back(std::move(*part));
  }
  OrientReport report;
  decide_turns(parts, find_outermost(mesh, parts, flip, report), report);
  for (const Part& part : parts) {
    for (const std::int32_t t : part.triangles) {
      if (static_cast<bool>(flip[t]) == part.turn)
        continue;
      std::swap(mesh.triangles(t, 1), mesh.triangles(t, 2));
      ++report.flipped;
    }
  }
  return report;
}

} // namespace wry::geometry
