#include "sim/geometry/remesh.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/geometry/closest_point_tree.h"
#include "sim/geometry/mesh_checks.h"
#include "sim/geometry/primitives.h"
#include "sim/geometry/tet_quality.h"
#include "tests/geometry/volumes_support.h"

namespace wry::geometry {
namespace {

struct Shape {
  double mean_edge = 0;
  double min_angle = 180; ///< [degrees]
  double off_surface = 0; ///< greatest distance of a vertex [m]
};

Shape shape_of(const SurfaceMesh& mesh, const SurfaceMesh& original) {
  Shape shape;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = mesh.vertices.row(mesh.triangles(t, k)).transpose();
      const Vec3 b = mesh.vertices.row(mesh.triangles(t, (k + 1) % 3)).transpose() - a;
      const Vec3 c = mesh.vertices.row(mesh.triangles(t, (k + 2) % 3)).transpose() - a;
      shape.mean_edge += b.norm() / static_cast<double>(3 * mesh.triangles.rows());
      shape.min_angle = std::min(shape.min_angle, std::acos(b.dot(c) / b.norm() / c.norm()) * 180 / M_PI);
    }
  }
  const ClosestPointTree tree(original);
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
    shape.off_surface = std::max(shape.off_surface, tree.closest(mesh.vertices.row(v).transpose()).distance);
  return shape;
}

void expect_sound(const SurfaceMesh& mesh, const std::string& name) {
  const MeshReport report = inspect_mesh(mesh);
  EXPECT_TRUE(report.is_closed()) << name;
  EXPECT_TRUE(report.is_manifold()) << name;
  EXPECT_TRUE(report.is_oriented()) << name;
  EXPECT_EQ(report.unused_vertices, 0) << name;
}

TEST(Remesh, MakesEvenTrianglesCoarserAndFiner) {
  const SurfaceMesh torus = *make_torus(0.5, 0.2, Axis::y, 0.05);
  for (const double edge : {0.1, 0.05, 0.025}) {
    const Result<SurfaceMesh> mesh = remesh(torus, edge);
    ASSERT_TRUE(mesh.ok());
    expect_sound(*mesh, "torus");
    const Shape shape = shape_of(*mesh, torus);
    EXPECT_NEAR(shape.mean_edge, edge, 0.15 * edge);
    EXPECT_GT(shape.min_angle, 25);
    EXPECT_LT(shape.off_surface, 1e-12);
  }
}

TEST(Remesh, KeepsTheEdgesAndCornersOfABox) {
  const SurfaceMesh box = *make_block_surface(box_block({1.0, 0.6, 0.4}), 0.05);
  const Result<SurfaceMesh> mesh = remesh(box, 0.11);
  ASSERT_TRUE(mesh.ok());
  expect_sound(*mesh, "box");
  EXPECT_NEAR(enclosed_volume(mesh->vertices, mesh->triangles), 0.24, 1e-9);
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::RowVector3d x(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.3 : -0.3, corner & 4 ? 0.2 : -0.2);
    EXPECT_LT((mesh->vertices.rowwise() - x).rowwise().norm().minCoeff(), 1e-9);
  }
}

TEST(Remesh, RefinesWhereTheSurfaceBends) {
  const SurfaceMesh torus = *make_torus(0.5, 0.08, Axis::y, 0.02);
  RemeshSettings settings;
  settings.edge = 0.16;
  settings.finest = 0.1;
  std::vector<double> edges;
  for (const double turn : {60.0, 30.0}) {
    settings.turn = turn;
    const Result<SurfaceMesh> mesh = remesh(torus, settings);
    ASSERT_TRUE(mesh.ok());
    expect_sound(*mesh, "thin torus");
    edges.push_back(shape_of(*mesh, torus).mean_edge);
  }
  // An edge of the tube that spans the angle is as long as the arc; the bend around the hole adds a little.
  EXPECT_NEAR(edges[0], 60 * M_PI / 180 * 0.08, 0.02);
  EXPECT_NEAR(edges[1] / edges[0], 0.5, 0.05);
}

TEST(Remesh, KeepsTheBunnyWholeAtManyResolutions) {
  const SurfaceMesh bunny = bunny_surface();
  for (const double edge : {0.06, 0.045, 0.02}) {
    RemeshSettings settings;
    settings.edge = edge;
    settings.finest = 0.5;
    const Result<SurfaceMesh> mesh = remesh(bunny, settings);
    ASSERT_TRUE(mesh.ok());
    expect_sound(*mesh, "bunny");
    EXPECT_EQ(inspect_mesh(*mesh).components, 1);
    EXPECT_EQ(find_self_intersections(*mesh, Threads(1)).pairs.size(), 0U);
    EXPECT_GT(shape_of(*mesh, bunny).min_angle, 10) << edge;
  }
}

TEST(Remesh, RefusesOpenNonManifoldAndSenselessInput) {
  const SurfaceMesh sphere = *make_sphere(0.5, 0.1);
  const Result<SurfaceMesh> open = remesh(without_triangles(sphere, 1), 0.1);
  ASSERT_FALSE(open.ok());
  EXPECT_THAT(open.error().message, testing::HasSubstr("open"));
  SurfaceMesh tripled = sphere;
  tripled.triangles.conservativeResize(sphere.triangles.rows() + 1, 3);
  tripled.triangles.bottomRows(1) = sphere.triangles.row(0);
  EXPECT_FALSE(remesh(tripled, 0.1).ok());
  SurfaceMesh turned = sphere;
  std::swap(turned.triangles(0, 0), turned.triangles(0, 1));
  EXPECT_FALSE(remesh(turned, 0.1).ok());
  EXPECT_FALSE(remesh(sphere, 0.0).ok());
  EXPECT_FALSE(remesh(sphere, -1.0).ok());
  EXPECT_FALSE(remesh(SurfaceMesh{}, 0.1).ok());
}

} // namespace
} // namespace wry::geometry
