// Writes shots/meshes/bunny.obj: our own rabbit, modelled by distance functions. Usage: make_bunny OUT.obj [EDGE]

#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "shots/meshes/make/bunny_shape.h"
#include "sim/geometry/isosurface_stuffing.h"
#include "sim/geometry/remesh.h"

namespace {

using namespace wry;
using namespace wry::geometry;

/// Draws a point onto the zero set along the gradient.
Vec3 put_on_shape(Vec3 x) {
  constexpr double STEP = 1e-5;
  for (int i = 0; i < 8; ++i) {
    Vec3 gradient;
    for (int k = 0; k < 3; ++k)
      gradient[k] = (make::bunny_distance(x + STEP * Vec3::Unit(k)) - make::bunny_distance(x - STEP * Vec3::Unit(k))) /
                    (2 * STEP);
    x -= make::bunny_distance(x) * gradient / std::max(gradient.squaredNorm(), 0.04);
  }
  return x;
}

Result<SurfaceMesh> make_surface(double edge) {
  StuffingSettings settings;
  settings.edge = 0.8 * edge;
  const Bounds bounds{{-0.5, -0.05, -0.7}, {0.5, 1.3, 0.6}};
  Result<TetMesh> filled = stuff_isosurface(make::bunny_distance, bounds, 0.0, settings);
  if (!filled)
    return filled.error();
  SurfaceMesh fine{filled->vertices, boundary_triangles(*filled), {}};
  Result<SurfaceMesh> even = remesh(fine, edge);
  if (!even)
    return even.error();
  for (Eigen::Index i = 0; i < even->vertices.rows(); ++i)
    even->vertices.row(i) = put_on_shape(even->vertices.row(i).transpose()).transpose();
  // One metre tall, standing on y = 0.
  const double low = even->vertices.col(1).minCoeff();
  const double height = even->vertices.col(1).maxCoeff() - low;
  even->vertices.col(1).array() -= low;
  even->vertices /= height;
  return even;
}

bool write_obj(const SurfaceMesh& mesh, const char* path) {
  std::ofstream file(path, std::ios::binary);
  file << "# A rabbit of our own, modelled by signed distance: shots/meshes/make/bunny_shape.cpp. Apache-2.0.\n";
  for (Eigen::Index i = 0; i < mesh.vertices.rows(); ++i)
    file << fmt::format("v {:.5f} {:.5f} {:.5f}\n", mesh.vertices(i, 0), mesh.vertices(i, 1), mesh.vertices(i, 2));
  for (Eigen::Index i = 0; i < mesh.triangles.rows(); ++i)
    file << fmt::format("f {} {} {}\n", mesh.triangles(i, 0) + 1, mesh.triangles(i, 1) + 1, mesh.triangles(i, 2) + 1);
  file.close();
  return !file.fail();
}

} // namespace

int main(int count, char** arguments) {
  if (count < 2) {
    std::fprintf(stderr, "usage: make_bunny OUT.obj [EDGE]\n");
    return 2;
  }
  const Result<SurfaceMesh> mesh = make_surface(count > 2 ? std::atof(arguments[2]) : 0.0135);
  if (!mesh) {
    std::fprintf(stderr, "%s\n", mesh.error().message.c_str());
    return static_cast<int>(mesh.error().code);
  }
  if (!write_obj(*mesh, arguments[1])) {
    std::fprintf(stderr, "cannot write %s\n", arguments[1]);
    return static_cast<int>(ErrorCode::cannot_write);
  }
  fmt::print("{} triangles, {} vertices\n", mesh->triangles.rows(), mesh->vertices.rows());
  return 0;
}
