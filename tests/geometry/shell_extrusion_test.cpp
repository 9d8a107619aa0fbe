#include "sim/geometry/shell_extrusion.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/geometry/closest_point_tree.h"
#include "sim/geometry/primitives.h"
#include "tests/geometry/volumes_support.h"

namespace wry::geometry {
namespace {

ShellSettings shell_settings(double thickness, double edge, int layers = 2) {
  ShellSettings settings;
  settings.thickness = thickness;
  settings.edge = edge;
  settings.layers = layers;
  return settings;
}

void expect_sound(const ShellMesh& shell) {
  EXPECT_GE(shell.quality.min_dihedral, 5);
  EXPECT_LE(shell.quality.max_dihedral, 165);
  EXPECT_GT(shell.quality.min_volume, 0);
  EXPECT_EQ(shell.quality.non_manifold_edges, 0);
  EXPECT_EQ(shell.quality.non_manifold_vertices, 0);
  EXPECT_EQ(shell.quality.overused_faces, 0);
  EXPECT_EQ(shell.quality.components, 1);
  EXPECT_LE(shell.volume_error, .02);
  EXPECT_EQ(boundary_self_intersections(shell.mesh), 0U);
}

TEST(ShellExtrusion, HollowsASphereToTheWallAsked) {
  const SurfaceMesh sphere = *make_sphere(0.5, 0.02);
  for (const double edge : {0.12, 0.08, 0.05}) {
    const Result<ShellMesh> shell = extrude_shell(sphere, shell_settings(0.05, edge));
    ASSERT_TRUE(shell.ok()) << shell.error().message;
    expect_sound(*shell);
    EXPECT_EQ(shell->method, ShellMethod::extruded);
    const double exact = 4 * M_PI / 3 * (std::pow(0.5, 3) - std::pow(0.45, 3));
    EXPECT_NEAR(shell->quality.volume, exact, 0.02 * exact);
    EXPECT_NEAR(shell->reference_volume, exact, 0.005 * exact);
    EXPECT_NEAR(shell->min_wall, 0.05, 0.005);
    EXPECT_NEAR(shell->max_wall, 0.05, 0.005);
  }
}

TEST(ShellExtrusion, HollowsTorusAndRoundedBoxAtSeveralResolutions) {
  const SurfaceMesh torus = *make_torus(0.5, 0.2, Axis::y, 0.03);
  const SurfaceMesh box = rounded_box({0.5, 0.3, 0.4}, 0.1, 0.03);
  for (const double edge : {0.12, 0.08, 0.05}) {
    for (const SurfaceMesh* surface : {&torus, &box}) {
      const Result<ShellMesh> shell = extrude_shell(*surface, shell_settings(0.04, edge));
      ASSERT_TRUE(shell.ok()) << shell.error().message;
      expect_sound(*shell);
      EXPECT_TRUE(shell->thin_places.empty());
    }
  }
}

TEST(ShellExtrusion, HollowsABoxWithSharpEdges) {
  const SurfaceMesh box = *make_block_surface(box_block({1.0, 0.6, 0.8}), 0.1);
  const Result<ShellMesh> shell = extrude_shell(box, shell_settings(0.04, 0.08));
  ASSERT_TRUE(shell.ok()) << shell.error().message;
  expect_sound(*shell);
  const double exact = 0.48 - 0.92 * 0.52 * 0.72;
  EXPECT_NEAR(shell->quality.volume, exact, 0.02 * exact);
}

TEST(ShellExtrusion, HollowsTheBunnyAtTheResolutionsOfTheStudy) {
  const SurfaceMesh bunny = bunny_surface();
  for (const double edge : {0.06, 0.045, 0.03}) {
    const Result<ShellMesh> shell = extrude_shell(bunny, shell_settings(0.02, edge));
    ASSERT_TRUE(shell.ok()) << shell.error().message;
    expect_sound(*shell);
  }
}

TEST(ShellExtrusion, LayersLieBetweenTheSurfaceAndTheWall) {
  const SurfaceMesh sphere = *make_sphere(0.5, 0.02);
  for (const int layers : {1, 2, 3, 4}) {
    const Result<ShellMesh> shell = extrude_shell(sphere, shell_settings(0.06, 0.07, layers));
    ASSERT_TRUE(shell.ok()) << shell.error().message;
    expect_sound(*shell);
    EXPECT_EQ(shell->mesh.vertices.rows(), (layers + 1) * shell->columns);
    EXPECT_EQ(shell->mesh.tets.rows(), 3 * layers * shell->outer_triangles.rows());
    for (int layer = 0; layer <= layers; ++layer)
      for (int column = 0; column < shell->columns; column += 7)
        EXPECT_NEAR(shell->mesh.vertices.row(layer * shell->columns + column).norm(), 0.5 - 0.06 * layer / layers,
                    0.004);
  }
}

TEST(ShellExtrusion, LeansColumnsAtTheCornersOfACoarseBox) {
  // Twelve triangles; edges finer than the wall is thick lie close to every corner.
  const SurfaceMesh box = *make_block_surface(box_block({1.0, 0.6, 0.8}), 2.0);
  const Result<ShellMesh> shell = extrude_shell(box, shell_settings(0.04, 0.08));
  ASSERT_TRUE(shell.ok()) << shell.error().message;
  expect_sound(*shell);
  EXPECT_TRUE(shell->thin_places.empty());
  EXPECT_NEAR(shell->min_wall, 0.04, 1e-4);
}

TEST(ShellExtrusion, KeepsTheTwoSidesOfAThinPlateApart) {
  const SurfaceMesh plate = *make_block_surface(box_block({0.6, 0.03, 0.5}), 0.05);
  const Result<ShellMesh> shell = extrude_shell(plate, shell_settings(0.02, 0.05));
  ASSERT_TRUE(shell.ok()) << shell.error().message;
  expect_sound(*shell);
  EXPECT_EQ(shell->method, ShellMethod::extruded_with_thinner_walls);
  EXPECT_LT(shell->max_wall, 0.013);
}

TEST(ShellExtrusion, NamesThePlaceThatIsTooThin) {
  // A plate of 3 cm has no room for two walls of 2 cm.
  const SurfaceMesh plate = rounded_box({0.3, 0.015, 0.2}, 0.0149, 0.01);
  ShellSettings settings = shell_settings(0.02, 0.03);
  settings.thin_places = ThinPlaces::refuse;
  const Result<ShellMesh> refused = extrude_shell(plate, settings);
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(refused.error().message,
              testing::AllOf(testing::HasSubstr("a wall of 0.02 m does not fit at"), testing::HasSubstr("deep there")));
}

TEST(ShellExtrusion, MakesThinnerWallsWhereABodyTapersAndSaysSo) {
  // A drop whose tip is thinner than two walls.
  SurfaceMesh drop = *make_sphere(0.3, 0.02);
  for (Eigen::Index i = 0; i < drop.vertices.rows(); ++i) {
    const double y = drop.vertices(i, 1) / 0.3;
    const double narrowing = y > 0 ? 1 - 0.9 * y * y : 1;
    drop.vertices(i, 0) *= narrowing;
    drop.vertices(i, 2) *= narrowing;
    drop.vertices(i, 1) *= y > 0 ? 2.2 : 1;
  }
  const Result<ShellMesh> shell = extrude_shell(drop, shell_settings(0.03, 0.05));
  ASSERT_TRUE(shell.ok()) << shell.error().message;
  EXPECT_EQ(shell->method, ShellMethod::extruded_with_thinner_walls);
  ASSERT_EQ(shell->thin_places.size(), 1U);
  EXPECT_GT(shell->thin_places[0].point.y(), 0.5);
  EXPECT_LT(shell->thin_places[0].thickness, 0.03);
  EXPECT_GT(shell->quality.min_volume, 0);
}

TEST(ShellExtrusion, RefusesOpenSurfacesAndSenselessSettings) {
  const SurfaceMesh sphere = *make_sphere(0.5, 0.1);
  const Result<ShellMesh> open = extrude_shell(without_triangles(sphere, 4), shell_settings(0.05, 0.1));
  ASSERT_FALSE(open.ok());
  EXPECT_THAT(open.error().message, testing::HasSubstr("open"));
  EXPECT_FALSE(extrude_shell(sphere, shell_settings(0, 0.1)).ok());
  EXPECT_FALSE(extrude_shell(sphere, shell_settings(0.05, 0)).ok());
  EXPECT_FALSE(extrude_shell(sphere, shell_settings(0.05, 0.1, 0)).ok());
}

TEST(ShellExtrusion, GivesTheSameBitsEveryTime) {
  const SurfaceMesh bunny = bunny_surface();
  const Result<ShellMesh> a = extrude_shell(bunny, shell_settings(0.02, 0.06));
  const Result<ShellMesh> b = extrude_shell(bunny, shell_settings(0.02, 0.06));
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a->mesh.vertices, b->mesh.vertices);
  EXPECT_EQ(a->mesh.tets, b->mesh.tets);
}

} // namespace
} // namespace wry::geometry
