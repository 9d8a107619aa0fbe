#include "sim/geometry/weld.h"

#include <algorithm>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "sim/geometry/mesh_checks.h"
#include "sim/geometry/primitives.h"

namespace wry::geometry {
namespace {

// Every triangle with its own three vertices, as STL files have them.
SurfaceMesh soup_of(const SurfaceMesh& mesh) {
  SurfaceMesh soup;
  soup.vertices.resize(mesh.triangles.size(), 3);
  soup.triangles.resize(mesh.triangles.rows(), 3);
  VertexAttribute origin{"origin", 2, {}};
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      soup.vertices.row(3 * t + k) = mesh.vertices.row(mesh.triangles(t, k));
      soup.triangles(t, k) = static_cast<std::int32_t>(3 * t + k);
      origin.values.push_back(mesh.triangles(t, k));
      origin.values.push_back(-1);
    }
  }
  soup.attributes.push_back(origin);
  return soup;
}

TEST(Weld, SoupBecomesAClosedMeshAgain) {
  const SurfaceMesh sphere = make_sphere(1.0, 0.1).value();
  for (const double tolerance : {0.0, 1e-6}) {
    SurfaceMesh soup = soup_of(sphere);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> noise(-1, 1);
    if (tolerance > 0)
      soup.vertices = soup.vertices.unaryExpr([&](double x) { return x + 0.2e-6 * noise(random); }).eval();
    EXPECT_FALSE(inspect_mesh(soup).is_closed());
    const Result<WeldedMesh> welded = weld(soup, tolerance);
    ASSERT_TRUE(welded);
    EXPECT_TRUE(inspect_mesh(welded->mesh).is_closed());
    EXPECT_EQ(welded->mesh.vertices.rows(), sphere.vertices.rows());
    EXPECT_EQ(welded->mesh.triangles.rows(), sphere.triangles.rows());
    EXPECT_EQ(welded->dropped_triangles, 0);
    EXPECT_EQ(welded->merged_vertices, soup.vertices.rows() - sphere.vertices.rows());
    // The map takes every old vertex to a new one at the same place, and attributes come along.
    for (Eigen::Index v = 0; v < soup.vertices.rows(); ++v) {
      const std::int32_t to = welded->map[v];
      ASSERT_GE(to, 0);
      EXPECT_LE((soup.vertices.row(v) - welded->mesh.vertices.row(to)).norm(), tolerance);
      EXPECT_EQ(welded->mesh.attributes[0].values[2 * to], soup.attributes[0].values[2 * v]);
    }
  }
}

TEST(Weld, DropsWhatCollapsesRepeatsOrIsUnused) {
  SurfaceMesh mesh;
  mesh.vertices.resize(6, 3);
  mesh.vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1e-9, 5, 5, 5, 1, 1, 0;
  mesh.triangles.resize(4, 3);
  mesh.triangles << 0, 1, 2, 0, 3, 1, 2, 3, 1, 1, 5, 2;
  const Result<WeldedMesh> welded = weld(mesh, 1e-6);
  ASSERT_TRUE(welded);
  EXPECT_EQ(welded->mesh.triangles.rows(), 2);
  EXPECT_EQ(welded->dropped_triangles, 2);
  EXPECT_EQ(welded->unused_vertices, 1);
  EXPECT_EQ(welded->map, (std::vector<std::int32_t>{0, 1, 2, 0, -1, 3}));
}

TEST(Weld, NegativeZeroIsZeroAndNearStaysApartAtZeroTolerance) {
  SurfaceMesh mesh;
  mesh.vertices.resize(6, 3);
  mesh.vertices << 0.0, 0, 0, 1, 0, 0, 0, 1, 0, -0.0, -0.0, 0, 0, 1, 1e-300, 1, 0, 1;
  mesh.triangles.resize(2, 3);
  mesh.triangles << 0, 1, 2, 3, 4, 5;
  const Result<WeldedMesh> welded = weld(mesh, 0);
  ASSERT_TRUE(welded);
  EXPECT_EQ(welded->merged_vertices, 1);
}

TEST(Weld, RefusesWhatItCannotResolve) {
  SurfaceMesh mesh = make_block_surface(box_block({1, 1, 1}), 1).value();
  EXPECT_FALSE(weld(mesh, -1));
  EXPECT_FALSE(weld(mesh, 1e-300));
  EXPECT_FALSE(weld(mesh, std::numeric_limits<double>::quiet_NaN()));
  mesh.triangles(0, 0) = 99;
  EXPECT_FALSE(weld(mesh, 0));
  mesh.triangles(0, 0) = 0;
  mesh.vertices(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(weld(mesh, 0));
}

} // namespace
} // namespace wry::geometry
