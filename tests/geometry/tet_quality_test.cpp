#include "sim/geometry/tet_quality.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace wry::geometry {
namespace {

/// Two tets that share the face 1 2 3.
TetMesh two_tets() {
  TetMesh mesh;
  mesh.vertices.resize(5, 3);
  mesh.vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1;
  mesh.tets.resize(2, 4);
  mesh.tets << 0, 1, 2, 3, 1, 2, 3, 4;
  return mesh;
}

TEST(TetQuality, KnowsTheAnglesOfARegularTet) {
  const std::array<Vec3, 4> x{Vec3(1, 1, 1), Vec3(1, -1, -1), Vec3(-1, 1, -1), Vec3(-1, -1, 1)};
  for (const double angle : dihedral_angles(x))
    EXPECT_NEAR(angle, std::acos(1.0 / 3.0) * 180 / M_PI, 1e-12);
}

TEST(TetQuality, KnowsTheAnglesOfACubeCorner) {
  const std::array<double, 6> angles = dihedral_angles({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)});
  const double slanted = std::acos(1 / std::sqrt(3.0)) * 180 / M_PI;
  EXPECT_THAT(angles, testing::ElementsAre(testing::DoubleNear(90, 1e-12), testing::DoubleNear(90, 1e-12),
                                           testing::DoubleNear(90, 1e-12), testing::DoubleNear(slanted, 1e-12),
                                           testing::DoubleNear(slanted, 1e-12), testing::DoubleNear(slanted, 1e-12)));
}

TEST(TetQuality, MeasuresVolumesEdgesAndPieces) {
  const TetQuality quality = measure(two_tets());
  EXPECT_EQ(quality.tets, 2);
  EXPECT_EQ(quality.vertices, 5);
  EXPECT_NEAR(quality.volume, 1.0 / 6 + 1.0 / 3, 1e-15);
  EXPECT_NEAR(quality.min_volume, 1.0 / 6, 1e-15);
  EXPECT_NEAR(quality.min_edge, 1, 1e-15);
  EXPECT_NEAR(quality.max_edge, std::sqrt(2.0), 1e-15);
  EXPECT_EQ(quality.components, 1);
  EXPECT_EQ(quality.non_manifold_edges, 0);
  EXPECT_EQ(quality.non_manifold_vertices, 0);
  std::int64_t counted = 0;
  for (const std::int64_t bin : quality.dihedral_histogram)
    counted += bin;
  EXPECT_EQ(counted, 12);
}

TEST(TetQuality, SeesTetsThatTouchInAnEdgeOrAVertexOnly) {
  TetMesh mesh;
  mesh.vertices.resize(6, 3);
  mesh.vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1;
  mesh.tets.resize(2, 4);
  mesh.tets << 0, 1, 2, 3, 0, 1, 4, 5;
  const TetQuality edge = measure(mesh);
  EXPECT_EQ(edge.non_manifold_edges, 1);
  EXPECT_EQ(edge.components, 2);
  mesh.vertices.conservativeResize(7, 3);
  mesh.vertices.row(6) << -1, 0, 0;
  mesh.tets.row(1) << 0, 4, 6, 5;
  const TetQuality vertex = measure(mesh);
  EXPECT_EQ(vertex.non_manifold_edges, 0);
  EXPECT_EQ(vertex.non_manifold_vertices, 1);
}

TEST(TetQuality, GateNamesWhatIsWrongAndWhere) {
  const TetLimits limits{10, 165, .02};
  TetMesh mesh = two_tets();
  EXPECT_TRUE(gate(mesh, measure(mesh), limits, 0.5, "block").ok());

  const Status volume = gate(mesh, measure(mesh), limits, 0.6, "block");
  ASSERT_FALSE(volume.ok());
  EXPECT_THAT(volume.error().message, testing::HasSubstr("16.67 %"));

  std::swap(mesh.tets(1, 0), mesh.tets(1, 1));
  const Status inverted = gate(mesh, measure(mesh), limits, 0, "block");
  ASSERT_FALSE(inverted.ok());
  EXPECT_THAT(inverted.error().message, testing::AllOf(testing::HasSubstr("block"), testing::HasSubstr("tet 1 at"),
                                                       testing::HasSubstr("positive volume")));

  mesh = two_tets();
  mesh.vertices.row(4) << 0.34, 0.34, 0.34;
  const Status sliver = gate(mesh, measure(mesh), limits, 0, "block");
  ASSERT_FALSE(sliver.ok());
  EXPECT_THAT(sliver.error().message, testing::HasSubstr("dihedral angle"));

  mesh = two_tets();
  mesh.vertices.conservativeResize(6, 3);
  mesh.vertices.row(5).setZero();
  EXPECT_FALSE(gate(mesh, measure(mesh), limits, 0, "block").ok());
  EXPECT_FALSE(gate(TetMesh{}, measure(TetMesh{}), limits, 0, "block").ok());
}

} // namespace
} // namespace wry::geometry
