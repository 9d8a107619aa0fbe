#include "sim/geometry/isosurface_stuffing.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/geometry/primitives.h"
#include "tests/geometry/volumes_support.h"

namespace wry::geometry {
namespace {

void expect_sound(const SolidMesh& solid) {
  EXPECT_GE(solid.quality.min_dihedral, 10);
  EXPECT_LE(solid.quality.max_dihedral, 165);
  EXPECT_GT(solid.quality.min_volume, 0);
  EXPECT_EQ(solid.quality.non_manifold_edges, 0);
  EXPECT_EQ(solid.quality.non_manifold_vertices, 0);
  EXPECT_EQ(solid.quality.unused_vertices, 0);
}

Result<SolidMesh> stuff(const SurfaceMesh& surface, double edge) {
  StuffingSettings settings;
  settings.edge = edge;
  return stuff_solid(surface, settings);
}

class SolidStuffing : public testing::Test {
protected:
  void SetUp() override {
    const Result<SolidMesh> probe = stuff(*make_sphere(1, 0.5), 0.5);
    if (!probe && probe.error().code == ErrorCode::unavailable)
      GTEST_SKIP() << probe.error().message;
  }
};

TEST_F(SolidStuffing, PassesTheGateOnRoundShapes) {
  const std::vector<std::pair<SurfaceMesh, double>> shapes{
      {*make_sphere(0.5, 0.03), 4 * M_PI / 3 * 0.125},
      {*make_torus(0.5, 0.2, Axis::y, 0.03), 2 * M_PI * M_PI * 0.5 * 0.04},
      {*make_block_surface(box_block({0.9, 0.6, 0.4}), 0.05), 0.9 * 0.6 * 0.4},
      {*make_block_surface(cylinder_block(0.3, 1.0), 0.03), M_PI * 0.09},
  };
  for (const auto& [surface, volume] : shapes) {
    for (const double edge : {0.13, 0.08, 0.05}) {
      const Result<SolidMesh> solid = stuff(surface, edge);
      ASSERT_TRUE(solid.ok()) << solid.error().message;
      expect_sound(*solid);
      EXPECT_EQ(solid->quality.components, 1);
      EXPECT_NEAR(solid->quality.volume, volume, 0.02 * volume);
      EXPECT_LT(solid->quality.max_edge, 1.6 * edge);
    }
  }
}

TEST_F(SolidStuffing, PassesTheGateOnTheBunny) {
  const SurfaceMesh bunny = bunny_surface();
  const double volume = enclosed_volume(bunny.vertices, bunny.triangles);
  for (const double edge : {0.06, 0.045}) {
    const Result<SolidMesh> solid = stuff(bunny, edge);
    ASSERT_TRUE(solid.ok()) << solid.error().message;
    expect_sound(*solid);
    EXPECT_NEAR(solid->quality.volume, volume, 0.02 * volume);
  }
}

TEST_F(SolidStuffing, PassesTheGateOnAPlateTwoEdgesThick) {
  const Result<SolidMesh> solid = stuff(*make_block_surface(box_block({1, 0.1, 0.8}), 0.1), 0.05);
  ASSERT_TRUE(solid.ok()) << solid.error().message;
  expect_sound(*solid);
}

TEST_F(SolidStuffing, RefusesWhatIsOpenOrThinnerThanTheLattice) {
  EXPECT_FALSE(stuff(without_triangles(*make_sphere(0.5, 0.1), 2), 0.1).ok());
  const Result<SolidMesh> thin = stuff(*make_block_surface(box_block({1, 0.01, 1}), 0.1), 0.2);
  ASSERT_FALSE(thin.ok());
  EXPECT_THAT(thin.error().message, testing::HasSubstr("resolution"));
  EXPECT_FALSE(stuff(*make_sphere(0.5, 0.1), 0.0).ok());
  EXPECT_FALSE(stuff(*make_sphere(0.5, 0.1), 1e-5).ok());
}

TEST(IsosurfaceStuffing, VolumeOfASphereConvergesWithTheSquareOfTheEdge) {
  const auto sphere = [](const Vec3& x) { return x.norm() - 0.5; };
  std::vector<double> errors;
  for (const double edge : {0.12, 0.06, 0.03}) {
    StuffingSettings settings;
    settings.edge = edge;
    const Result<TetMesh> mesh = stuff_isosurface(sphere, {Vec3::Constant(-0.6), Vec3::Constant(0.6)}, 0, settings);
    ASSERT_TRUE(mesh.ok());
    errors.push_back(4 * M_PI / 3 * 0.125 - measure(*mesh).volume);
  }
  EXPECT_GT(errors[0], 0);
  EXPECT_NEAR(std::log2(errors[0] / errors[1]), 2, 0.25);
  EXPECT_NEAR(std::log2(errors[1] / errors[2]), 2, 0.25);
}

/// The bounds of the paper do not need a smooth function: any signs at the lattice points will do.
TEST(IsosurfaceStuffing, KeepsItsAnglesOnAnyFunction) {
  for (int seed = 1; seed <= 6; ++seed) {
    const auto waves = [seed](const Vec3& x) {
      return std::sin((17 + 3 * seed) * x.x() + seed) * std::cos(23 * x.y() - seed) +
             std::sin(29 * x.z() + x.x()) * 0.7;
    };
    StuffingSettings settings;
    settings.edge = 0.09;
    const Result<TetMesh> mesh = stuff_isosurface(waves, {Vec3::Constant(-0.5), Vec3::Constant(0.5)}, 0, settings);
    ASSERT_TRUE(mesh.ok());
    const TetQuality quality = measure(*mesh);
    EXPECT_GT(quality.tets, 1000);
    EXPECT_GT(quality.min_dihedral, 10.7);
    EXPECT_LT(quality.max_dihedral, 164.8);
    EXPECT_GT(quality.min_volume, 0);
    EXPECT_EQ(quality.overused_faces, 0);
  }
}

TEST(IsosurfaceStuffing, MeshesFitTogetherFaceToFace) {
  const auto ball = [](const Vec3& x) { return (x - Vec3(0.011, 0.023, 0.037)).norm() - 0.41; };
  StuffingSettings settings;
  settings.edge = 0.1;
  const Result<TetMesh> mesh = stuff_isosurface(ball, {Vec3::Constant(-0.5), Vec3::Constant(0.5)}, 0, settings);
  ASSERT_TRUE(mesh.ok());
  // If tets overlapped or left gaps, the volume within the boundary would differ from the sum over tets.
  const double enclosed = enclosed_volume(mesh->vertices, boundary_triangles(*mesh));
  EXPECT_NEAR(measure(*mesh).volume, enclosed, 1e-12);
  EXPECT_EQ(boundary_self_intersections(*mesh), 0U);
}

TEST(RemovePinches, LeavesAManifoldAndDropsCrumbs) {
  const auto noise = [](const Vec3& x) {
    const double wave = std::sin(41 * x.x()) * std::sin(37 * x.y()) * std::sin(43 * x.z()) - 0.05;
    return std::max(wave, x.norm() - 0.45) + 0.002 * std::sin(1000 * x.x());
  };
  StuffingSettings settings;
  settings.edge = 0.06;
  Result<TetMesh> mesh = stuff_isosurface(noise, {Vec3::Constant(-0.5), Vec3::Constant(0.5)}, 0, settings);
  ASSERT_TRUE(mesh.ok());
  const TetQuality before = measure(*mesh);
  ASSERT_GT(before.non_manifold_edges + before.non_manifold_vertices, 0);
  const std::int64_t removed = remove_pinches_and_crumbs(*mesh);
  const TetQuality after = measure(*mesh);
  EXPECT_EQ(after.non_manifold_edges, 0);
  EXPECT_EQ(after.non_manifold_vertices, 0);
  EXPECT_EQ(after.unused_vertices, 0);
  EXPECT_EQ(after.tets, before.tets - removed);
}

} // namespace
} // namespace wry::geometry
