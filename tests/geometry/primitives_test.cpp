#include "sim/geometry/primitives.h"

#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include <gtest/gtest.h>

#include "sim/geometry/mesh_checks.h"

namespace wry::geometry {
namespace {

constexpr double PI = std::numbers::pi;

void expect_closed_and_outward(const SurfaceMesh& mesh, int euler_characteristic) {
  const MeshReport report = inspect_mesh(mesh);
  EXPECT_TRUE(report.is_closed());
  EXPECT_TRUE(report.is_manifold());
  EXPECT_TRUE(report.is_oriented());
  EXPECT_EQ(report.components, 1);
  EXPECT_EQ(report.zero_area_triangles.count, 0);
  EXPECT_EQ(report.unused_vertices, 0);
  EXPECT_GT(report.volume, 0);
  EXPECT_EQ(mesh.vertices.rows() - mesh.triangles.rows() / 2, euler_characteristic);
}

double longest_edge(const SurfaceMesh& mesh) {
  double longest = 0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k)
      longest = std::max(
          longest,
          (mesh.vertices.row(mesh.triangles(t, k)) - mesh.vertices.row(mesh.triangles(t, (k + 1) % 3))).norm());
  return longest;
}

// Errors of area and volume against the closed form, at an edge and at half of it: second order, so a quarter.
void expect_second_order(const MeshReport& coarse, const MeshReport& fine, double area, double volume) {
  EXPECT_LT(coarse.area, area);
  EXPECT_LT(coarse.volume, volume);
  EXPECT_NEAR((area - fine.area) / (area - coarse.area), 0.25, 0.06);
  EXPECT_NEAR((volume - fine.volume) / (volume - coarse.volume), 0.25, 0.06);
  EXPECT_NEAR(fine.area, area, 0.01 * area);
  EXPECT_NEAR(fine.volume, volume, 0.01 * volume);
}

TEST(Primitives, BoxHasExactAreaAndVolume) {
  const Result<SurfaceMesh> mesh = make_block_surface(box_block({1.0, 0.5, 0.25}), 0.1);
  ASSERT_TRUE(mesh);
  expect_closed_and_outward(*mesh, 2);
  const MeshReport report = inspect_mesh(*mesh);
  EXPECT_NEAR(report.area, 2 * (0.5 + 0.125 + 0.25), 1e-12);
  EXPECT_NEAR(report.volume, 0.125, 1e-12);
  EXPECT_LE(longest_edge(*mesh), 0.1 * std::sqrt(2.0) + 1e-12);
}

TEST(Primitives, SphereConvergesToSecondOrder) {
  const Result<SurfaceMesh> coarse = make_sphere(2.0, 0.4);
  const Result<SurfaceMesh> fine = make_sphere(2.0, 0.2);
  ASSERT_TRUE(coarse && fine);
  expect_closed_and_outward(*fine, 2);
  expect_second_order(inspect_mesh(*coarse), inspect_mesh(*fine), 16 * PI, 32 * PI / 3);
  EXPECT_LE(longest_edge(*fine), 0.2 * 1.01);
  EXPECT_NEAR(fine->vertices.rowwise().norm().maxCoeff(), 2.0, 1e-14);
  EXPECT_NEAR(fine->vertices.rowwise().norm().minCoeff(), 2.0, 1e-14);
}

TEST(Primitives, CylinderConvergesToSecondOrderAlongEveryAxis) {
  for (const Axis axis : {Axis::x, Axis::y, Axis::z}) {
    const Block block = cylinder_block(0.5, 2.0, axis);
    EXPECT_EQ(block.size[axis_index(axis)], 2.0);
    const Result<SurfaceMesh> coarse = make_block_surface(block, 0.1);
    const Result<SurfaceMesh> fine = make_block_surface(block, 0.05);
    ASSERT_TRUE(coarse && fine);
    expect_closed_and_outward(*fine, 2);
    expect_second_order(inspect_mesh(*coarse), inspect_mesh(*fine), 2 * PI * 0.25 + 2 * PI * 0.5 * 2, PI * 0.25 * 2);
  }
}

TEST(Primitives, TorusConvergesToSecondOrder) {
  for (const Axis axis : {Axis::x, Axis::y, Axis::z}) {
    const Result<SurfaceMesh> coarse = make_torus(1.0, 0.3, axis, 0.1);
    const Result<SurfaceMesh> fine = make_torus(1.0, 0.3, axis, 0.05);
    ASSERT_TRUE(coarse && fine);
    expect_closed_and_outward(*fine, 0);
    expect_second_order(inspect_mesh(*coarse), inspect_mesh(*fine), 4 * PI * PI * 0.3, 2 * PI * PI * 0.09);
    EXPECT_NEAR(fine->vertices.col(axis_index(axis)).maxCoeff(), 0.3, 0.01);
  }
}

TEST(Primitives, RodLiesAlongItsAxisAndSheetAcrossItsNormal) {
  const Block rod = rod_block(3.0, 0.2, 0.1, Section::box);
  EXPECT_EQ(rod.size, Vec3(3.0, 0.1, 0.2));
  EXPECT_EQ(rod.u_axis, Axis::x);
  EXPECT_EQ(rod.v_axis, Axis::z);
  const Block sheet = sheet_block(2.0, 1.0, 0.01);
  EXPECT_EQ(sheet.size, Vec3(2.0, 0.01, 1.0));
  EXPECT_EQ(sheet.u_axis, Axis::x);
  EXPECT_EQ(sheet.v_axis, Axis::z);
  const Result<SurfaceMesh> mesh = make_block_surface(sheet, 0.05);
  ASSERT_TRUE(mesh);
  expect_closed_and_outward(*mesh, 2);
  EXPECT_NEAR(inspect_mesh(*mesh).volume, 0.02, 1e-14);
}

TEST(Primitives, EllipticRodKeepsBothDiameters) {
  const Result<SurfaceMesh> mesh = make_block_surface(rod_block(1.0, 0.4, 0.2, Section::round), 0.01);
  ASSERT_TRUE(mesh);
  const MeshReport report = inspect_mesh(*mesh);
  EXPECT_NEAR(report.extent().z(), 0.4, 1e-12);
  EXPECT_NEAR(report.extent().y(), 0.2, 1e-12);
  EXPECT_NEAR(report.volume, PI * 0.2 * 0.1, 1e-3 * PI * 0.02);
}

TEST(Primitives, BadSizesAreErrorsThatNameTheNumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(make_block_surface(box_block({1, -2, 1}), 0.1).error().code, ErrorCode::bad_input);
  EXPECT_NE(make_block_surface(box_block({1, -2, 1}), 0.1).error().message.find("-2"), std::string::npos);
  EXPECT_FALSE(make_block_surface(box_block({1, nan, 1}), 0.1));
  EXPECT_FALSE(make_block_surface(box_block({1, 1, 1}), 0));
  EXPECT_FALSE(make_block_surface(box_block({1, 1, 1}), 1e-300));
  EXPECT_FALSE(make_sphere(0, 0.1));
  EXPECT_FALSE(make_sphere(1, 1e-9));
  EXPECT_FALSE(make_torus(1, 1, Axis::y, 0.1));
  EXPECT_FALSE(make_torus(1, 0.1, Axis::y, nan));
}

} // namespace
} // namespace wry::geometry
