#include "tests/mpm/tank_support.h"

namespace wry::mpm {

namespace {

void add_corners(geometry::SurfaceMesh& mesh, const Vec3& low, const Vec3& high) {
  const Eigen::Index first = mesh.vertices.rows();
  mesh.vertices.conservativeResize(first + 8, 3);
  for (int i = 0; i < 8; ++i)
    mesh.vertices.row(first + i) << ((i & 1) != 0 ? high : low).x(), ((i & 2) != 0 ? high : low).y(),
        ((i & 4) != 0 ? high : low).z();
}

/// A quad, counter-clockwise seen from outside.
void add_quad(geometry::SurfaceMesh& mesh, int a, int b, int c, int d) {
  const Eigen::Index t = mesh.triangles.rows();
  mesh.triangles.conservativeResize(t + 2, 3);
  mesh.triangles.row(t) << a, b, c;
  mesh.triangles.row(t + 1) << a, c, d;
}

/// Outward faces of a box whose corners are 0 to 7, without its top.
void add_sides(geometry::SurfaceMesh& mesh) {
  add_quad(mesh, 0, 2, 3, 1);
  add_quad(mesh, 0, 1, 5, 4);
  add_quad(mesh, 2, 6, 7, 3);
  add_quad(mesh, 0, 4, 6, 2);
  add_quad(mesh, 1, 3, 7, 5);
}

} // namespace

geometry::SurfaceMesh box_mesh(const Vec3& low, const Vec3& high) {
  geometry::SurfaceMesh mesh;
  add_corners(mesh, low, high);
  add_sides(mesh);
  add_quad(mesh, 4, 5, 7, 6);
  return mesh;
}

geometry::SurfaceMesh tank(const Vec3& low, const Vec3& high, double wall) {
  geometry::SurfaceMesh mesh;
  add_corners(mesh, low, high);
  add_corners(mesh, low + Vec3::Constant(wall), Vec3(high.x() - wall, high.y() - wall, high.z()));
  add_sides(mesh);
  add_quad(mesh, 8, 9, 11, 10); // the pocket, seen from within
  add_quad(mesh, 8, 12, 13, 9);
  add_quad(mesh, 10, 11, 15, 14);
  add_quad(mesh, 8, 10, 14, 12);
  add_quad(mesh, 9, 13, 15, 11);
  add_quad(mesh, 4, 5, 13, 12); // the rim
  add_quad(mesh, 5, 7, 15, 13);
  add_quad(mesh, 7, 6, 14, 15);
  add_quad(mesh, 6, 4, 12, 14);
  return mesh;
}

} // namespace wry::mpm
