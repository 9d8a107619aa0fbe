#include "render/outward.h"

#include <gtest/gtest.h>

#include "tests/render/shapes_support.h"

namespace wry::render {
namespace {

SceneBody torus_body() {
  const geometry::SurfaceMesh mesh = testing::torus(Vec3(0, 0.35, 0), 0.8, 0.35, 12, 8);
  SceneBody body;
  body.simulated = false;
  body.rest_positions = mesh.vertices;
  body.triangles = mesh.triangles;
  return body;
}

/// Four of eight tets about the middle of an octahedron would do; one tet is matter enough.
SceneBody tet_body() {
  SceneBody body;
  body.rest_positions.resize(4, 3);
  body.rest_positions << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  body.tets.resize(1, 4);
  body.tets << 0, 1, 2, 3;
  body.triangles.resize(4, 3);
  body.triangles << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
  return body;
}

TEST(ClosedOutward, IsATorusAndATet) {
  EXPECT_TRUE(is_closed_outward(torus_body()));
  EXPECT_TRUE(is_closed_outward(tet_body()));
}

TEST(ClosedOutward, IsNoSurfaceWithAHoleOrATurnedTriangle) {
  SceneBody holed = torus_body();
  holed.triangles.conservativeResize(holed.triangles.rows() - 1, 3);
  EXPECT_FALSE(is_closed_outward(holed));
  SceneBody turned = torus_body();
  std::swap(turned.triangles(5, 0), turned.triangles(5, 1));
  EXPECT_FALSE(is_closed_outward(turned));
}

TEST(ClosedOutward, IsASurfaceWhoseSeamsLieOnEachOther) {
  // Each triangle with corners of its own, as files with textures have them.
  const SceneBody whole = torus_body();
  SceneBody torn = whole;
  torn.rest_positions.resize(3 * whole.triangles.rows(), 3);
  for (Eigen::Index t = 0; t < whole.triangles.rows(); ++t) {
    for (int c = 0; c < 3; ++c) {
      torn.rest_positions.row(3 * t + c) = whole.rest_positions.row(whole.triangles(t, c));
      torn.triangles(t, c) = static_cast<int>(3 * t + c);
    }
  }
  EXPECT_TRUE(is_closed_outward(torn));
}

TEST(ClosedOutward, IsNoInsideOutPieceBesideARightOne) {
  const SceneBody one = torus_body();
  SceneBody two = one;
  const Eigen::Index n = one.rest_positions.rows();
  two.rest_positions.conservativeResize(2 * n, 3);
  two.rest_positions.bottomRows(n) = (0.5 * one.rest_positions).rowwise() + Eigen::RowVector3d(5, 0, 0);
  two.triangles.conservativeResize(2 * one.triangles.rows(), 3);
  two.triangles.bottomRows(one.triangles.rows()) = one.triangles.array() + static_cast<int>(n);
  EXPECT_TRUE(is_closed_outward(two));
  two.triangles.bottomRows(one.triangles.rows()).col(0).swap(two.triangles.bottomRows(one.triangles.rows()).col(1));
  EXPECT_FALSE(is_closed_outward(two));
}

TEST(RightWayOut, IsMatterThatIsNeitherInvertedNorMirrored) {
  FrameBody frame;
  SceneBody body = tet_body();
  Points moved = body.rest_positions;
  EXPECT_TRUE(is_right_way_out(body, frame, moved));
  moved(3, 2) = -0.1;
  EXPECT_FALSE(is_right_way_out(body, frame, moved));
  const SceneBody torus = torus_body();
  EXPECT_TRUE(is_right_way_out(torus, frame, torus.rest_positions));
  frame.transform(1, 1) = -1.0;
  EXPECT_FALSE(is_right_way_out(torus, frame, torus.rest_positions));
  body.tets.resize(0, 4); // carried by something that is not known
  frame.transform(1, 1) = 1.0;
  EXPECT_FALSE(is_right_way_out(body, frame, body.rest_positions));
}

} // namespace
} // namespace wry::render
