#include "tests/geometry/volumes_support.h"

#include <array>
#include <fstream>
#include <sstream>
#include <vector>

#include "sim/geometry/isosurface_stuffing.h"
#include "sim/geometry/mesh_checks.h"

namespace wry::geometry {

SurfaceMesh bunny_surface() {
  std::ifstream file(std::string(WRY_SOURCE_DIR) + "/shots/meshes/bunny.obj");
  std::vector<std::array<double, 3>> vertices;
  std::vector<std::array<int, 3>> triangles;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v") {
      std::array<double, 3>& x = vertices.emplace_back();
      words >> x[0] >> x[1] >> x[2];
    } else if (kind == "f") {
      std::array<int, 3>& t = triangles.emplace_back();
      words >> t[0] >> t[1] >> t[2];
    }
  }
  SurfaceMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t i = 0; i < vertices.size(); ++i)
    for (int k = 0; k < 3; ++k)
      mesh.vertices(static_cast<Eigen::Index>(i), k) = vertices[i][k];
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (int k = 0; k < 3; ++k)
      mesh.triangles(static_cast<Eigen::Index>(i), k) = triangles[i][k] - 1;
  return mesh;
}

SurfaceMesh boundary_surface(const TetMesh& mesh) {
  return {mesh.vertices, boundary_triangles(mesh), {}};
}

std::size_t boundary_self_intersections(const TetMesh& mesh) {
  return find_self_intersections(boundary_surface(mesh), Threads(1)).pairs.size();
}

SurfaceMesh without_triangles(const SurfaceMesh& mesh, int count) {
  SurfaceMesh rest = mesh;
  rest.triangles = mesh.triangles.bottomRows(mesh.triangles.rows() - count).eval();
  return rest;
}

SurfaceMesh rounded_box(const Vec3& half_size, double radius, double edge) {
  const Vec3 core = half_size - Vec3::Constant(radius);
  const auto distance = [&](const Vec3& x) {
    const Vec3 q = x.cwiseAbs() - core;
    return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0) - radius;
  };
  StuffingSettings settings;
  settings.edge = edge;
  const Vec3 margin = Vec3::Constant(edge);
  return boundary_surface(*stuff_isosurface(distance, {-half_size - margin, half_size + margin}, 0, settings));
}

} // namespace wry::geometry
