#include "sim/geometry/tet_quality.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include <Eigen/Geometry>

namespace wry::geometry {

namespace {

constexpr int EDGES[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
constexpr int FACES[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

std::array<Vec3, 4> corners_of(const TetMesh& mesh, Eigen::Index tet) {
  std::array<Vec3, 4> corners;
  for (int k = 0; k < 4; ++k)
    corners[k] = mesh.vertices.row(mesh.tets(tet, k)).transpose();
  return corners;
}

std::size_t find_root(std::vector<std::size_t>& parent, std::size_t i) {
  while (parent[i] != i)
    i = parent[i] = parent[parent[i]];
  return i;
}

void measure_shapes(const TetMesh& mesh, TetQuality& quality) {
  double worst_angle = std::numeric_limits<double>::infinity();
  double edge_sum = 0;
  quality.min_edge = quality.min_volume = quality.min_dihedral = std::numeric_limits<double>::infinity();
  std::vector<std::array<std::int32_t, 2>> edges;
  edges.reserve(static_cast<std::size_t>(6 * mesh.tets.rows()));
  for (Eigen::Index tet = 0; tet < mesh.tets.rows(); ++tet) {
    const std::array<Vec3, 4> x = corners_of(mesh, tet);
    const double volume = (x[1] - x[0]).cross(x[2] - x[0]).dot(x[3] - x[0]) / 6.0;
    quality.volume += volume;
    quality.non_positive_tets += volume > 0 ? 0 : 1;
    if (volume < quality.min_volume) {
      quality.min_volume = volume;
      if (volume <= 0)
        quality.worst_tet = static_cast<std::int32_t>(tet);
    }
    for (const double angle : dihedral_angles(x)) {
      quality.max_dihedral = std::max(quality.max_dihedral, angle);
      quality.min_dihedral = std::min(quality.min_dihedral, angle);
      ++quality.dihedral_histogram[static_cast<std::size_t>(std::clamp(angle / 10.0, 0.0, 17.0))];
      const double badness = std::min(angle, 180 - angle);
      if (quality.min_volume > 0 && badness < worst_angle) {
        worst_angle = badness;
        quality.worst_tet = static_cast<std::int32_t>(tet);
      }
    }
    for (const auto& edge : EDGES) {
      const auto [low, high] = std::minmax(mesh.tets(tet, edge[0]), mesh.tets(tet, edge[1]));
      edges.push_back({low, high});
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  for (const auto& edge : edges) {
    const double length = (mesh.vertices.row(edge[0]) - mesh.vertices.row(edge[1])).norm();
    edge_sum += length;
    quality.min_edge = std::min(quality.min_edge, length);
    quality.max_edge = std::max(quality.max_edge, length);
  }
  quality.mean_edge = edge_sum / static_cast<double>(edges.size());
}

void measure_connections(const TetMesh& mesh, TetQuality& quality) {
  struct Face {
    std::array<std::int32_t, 3> key;
    std::size_t tet;
  };
  std::vector<Face> faces;
  std::vector<std::size_t> parent(static_cast<std::size_t>(mesh.tets.rows()));
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  for (std::size_t tet = 0; tet < parent.size(); ++tet) {
    for (const auto& face : FACES) {
      std::array<std::int32_t, 3> key{};
      for (int k = 0; k < 3; ++k)
        key[k] = mesh.tets(static_cast<Eigen::Index>(tet), face[k]);
      std::sort(key.begin(), key.end());
      faces.push_back({key, tet});
    }
  }
  std::sort(faces.begin(), faces.end(),
            [](const Face& a, const Face& b) { return a.key != b.key ? a.key < b.key : a.tet < b.tet; });
  for (std::size_t begin = 0; begin < faces.size();) {
    std::size_t end = begin + 1;
    for (; end < faces.size() && faces[end].key == faces[begin].key; ++end)
      parent[find_root(parent, faces[end].tet)] = find_root(parent, faces[begin].tet);
    quality.overused_faces += end - begin > 2 ? 1 : 0;
    begin = end;
  }
  for (std::size_t i = 0; i < parent.size(); ++i)
    quality.components += find_root(parent, i) == i ? 1 : 0;
}

/// Counts boundary edges without exactly two triangles, and boundary vertices whose triangles form more than one fan.
void measure_boundary(const TetMesh& mesh, TetQuality& quality) {
  const Triangles boundary = boundary_triangles(mesh);
  struct Side {
    std::int32_t low, high;
    std::size_t corner_low, corner_high;
  };
  std::vector<Side> sides;
  const std::size_t corners = static_cast<std::size_t>(3 * boundary.rows());
  std::vector<std::size_t> parent(corners);
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  for (std::size_t i = 0; i < corners; ++i) {
    const std::size_t next = i / 3 * 3 + (i + 1) % 3;
    const std::int32_t a = boundary.data()[i];
    const std::int32_t b = boundary.data()[next];
    sides.push_back(a < b ? Side{a, b, i, next} : Side{b, a, next, i});
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::array{a.low, a.high} != std::array{b.low, b.high}
               ? std::array{a.low, a.high} < std::array{b.low, b.high}
               : a.corner_low < b.corner_low;
  });
  for (std::size_t begin = 0; begin < sides.size();) {
    std::size_t end = begin + 1;
    for (; end < sides.size() && sides[end].low == sides[begin].low && sides[end].high == sides[begin].high; ++end) {
      parent[find_root(parent, sides[end].corner_low)] = find_root(parent, sides[begin].corner_low);
      parent[find_root(parent, sides[end].corner_high)] = find_root(parent, sides[begin].corner_high);
    }
    quality.non_manifold_edges += end - begin != 2 ? 1 : 0;
    begin = end;
  }
  std::vector<int> fans(static_cast<std::size_t>(mesh.vertices.rows()), 0);
  for (std::size_t i = 0; i < corners; ++i) {
    if (find_root(parent, i) == i)
      ++fans[static_cast<std::size_t>(boundary.data()[i])];
  }
  quality.non_manifold_vertices = std::count_if(fans.begin(), fans.end(), [](int count) { return count > 1; });
}

} // namespace

double tet_volume(const TetMesh& mesh, Eigen::Index tet) {
  const std::array<Vec3, 4> x = corners_of(mesh, tet);
  return (x[1] - x[0]).cross(x[2] - x[0]).dot(x[3] - x[0]) / 6.0;
}

std::array<double, 6> dihedral_angles(const std::array<Vec3, 4>& x) {
  std::array<double, 6> angles{};
  for (int i = 0; i < 6; ++i) {
    const int a = EDGES[i][0];
    const int b = EDGES[i][1];
    const int c = EDGES[5 - i][0];
    const int d = EDGES[5 - i][1];
    const Vec3 axis = x[b] - x[a];
    const Vec3 normal_c = axis.cross(x[c] - x[a]);
    const Vec3 normal_d = axis.cross(x[d] - x[a]);
    angles[i] = std::atan2(normal_c.cross(normal_d).norm(), normal_c.dot(normal_d)) * 180.0 / M_PI;
  }
  return angles;
}

TetQuality measure(const TetMesh& mesh) {
  TetQuality quality;
  quality.tets = mesh.tets.rows();
  quality.vertices = mesh.vertices.rows();
  std::vector<char> used(static_cast<std::size_t>(mesh.vertices.rows()), 0);
  for (Eigen::Index i = 0; i < mesh.tets.size(); ++i)
    used[static_cast<std::size_t>(mesh.tets.data()[i])] = 1;
  quality.unused_vertices = std::count(used.begin(), used.end(), 0);
  if (quality.tets == 0)
    return quality;
  measure_shapes(mesh, quality);
  measure_connections(mesh, quality);
  measure_boundary(mesh, quality);
  return quality;
}

double volume_error(const TetQuality& quality, double reference_volume) {
  return std::abs(quality.volume - reference_volume) / std::abs(reference_volume);
}

Status gate(const TetMesh& mesh, const TetQuality& quality, const TetLimits& limits, double reference_volume,
            const std::string& what) {
  const auto refuse = [&](const std::string& finding) {
    std::string place;
    if (quality.worst_tet >= 0) {
      Vec3 centre = Vec3::Zero();
      for (const Vec3& corner : corners_of(mesh, quality.worst_tet))
        centre += corner / 4.0;
      place = fmt::format("; worst is tet {} at ({:.4g}, {:.4g}, {:.4g}) m", quality.worst_tet, centre.x(), centre.y(),
                          centre.z());
    }
    return make_error(ErrorCode::bad_input,
                      "{}: the tet mesh {}{}. Try a smaller `resolution`, or mend the surface there.", what, finding,
                      place);
  };
  if (quality.tets == 0)
    return make_error(ErrorCode::bad_input,
                      "{}: the tet mesh is empty: nothing is as thick as the target edge. Try a "
                      "smaller `resolution`.",
                      what);
  if (quality.non_positive_tets > 0)
    return refuse(fmt::format("has {} tets without positive volume (least {:.3g} m^3)", quality.non_positive_tets,
                              quality.min_volume));
  if (quality.overused_faces > 0)
    return refuse(fmt::format("has {} faces that belong to more than two tets", quality.overused_faces));
  if (quality.non_manifold_edges > 0 || quality.non_manifold_vertices > 0)
    return refuse(fmt::format("has {} non-manifold edges and {} non-manifold vertices on its boundary",
                              quality.non_manifold_edges, quality.non_manifold_vertices));
  if (quality.unused_vertices > 0)
    return refuse(fmt::format("has {} vertices that no tet uses", quality.unused_vertices));
  if (quality.min_dihedral < limits.min_dihedral)
    return refuse(fmt::format("has a dihedral angle of {:.3g} degrees, the limit is {:.3g}", quality.min_dihedral,
                              limits.min_dihedral));
  if (quality.max_dihedral > limits.max_dihedral)
    return refuse(fmt::format("has a dihedral angle of {:.4g} degrees, the limit is {:.4g}", quality.max_dihedral,
                              limits.max_dihedral));
  if (reference_volume > 0 && volume_error(quality, reference_volume) > limits.volume_error)
    return refuse(fmt::format(
        "has a volume of {:.5g} m^3, the surface {:.5g} m^3: {:.2f} % apart, the limit is {:.2f} %", quality.volume,
        reference_volume, 100 * volume_error(quality, reference_volume), 100 * limits.volume_error));
  return {};
}

std::string describe(const TetQuality& quality) {
  return fmt::format("{} tets, {} vertices, edges {:.4g} to {:.4g} m (mean {:.4g}), dihedral angles {:.1f} to {:.1f} "
                     "degrees, least tet {:.3g} m^3, volume {:.5g} m^3",
                     quality.tets, quality.vertices, quality.min_edge, quality.max_edge, quality.mean_edge,
                     quality.min_dihedral, quality.max_dihedral, quality.min_volume, quality.volume);
}

double enclosed_volume(const Points& vertices, const Triangles& triangles) {
  const Vec3 origin = vertices.rows() > 0 ? Vec3(vertices.row(0).transpose()) : Vec3(Vec3::Zero());
  double volume = 0;
  for (Eigen::Index i = 0; i < triangles.rows(); ++i) {
    const Vec3 a = vertices.row(triangles(i, 0)).transpose() - origin;
    const Vec3 b = vertices.row(triangles(i, 1)).transpose() - origin;
    const Vec3 c = vertices.row(triangles(i, 2)).transpose() - origin;
    volume += a.dot(b.cross(c)) / 6.0;
  }
  return volume;
}

} // namespace wry::geometry
