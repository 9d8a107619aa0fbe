#include "sim/scene/transform.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace wry::scene {
namespace {

TEST(Transform, AxisTurnAgreesWithEigen) {
  for (const double degrees : {-725.0, -90.0, -30.0, 0.0, 17.0, 90.0, 135.0, 180.0, 270.0, 361.0}) {
    const Vec3 axis(1, -2, 0.5);
    const Result<Mat3> rotation = rotation_matrix(AxisTurn{axis, degrees});
    ASSERT_TRUE(rotation);
    const Mat3 expected = Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis.normalized()).toRotationMatrix();
    EXPECT_LT((*rotation - expected).norm(), 1e-13) << degrees;
  }
}

TEST(Transform, QuarterTurnsAreExact) {
  const Result<Mat3> turn = rotation_matrix(AxisTurn{{0, 0, 3}, 90});
  EXPECT_EQ(*turn * Vec3(1, 2, 3), Vec3(-2, 1, 3));
  EXPECT_EQ(*rotation_matrix(AxisTurn{{0, 5, 0}, -180}) * Vec3(1, 2, 3), Vec3(-1, 2, -3));
  EXPECT_EQ(*rotation_matrix(AxisTurn{{1, 0, 0}, 270}) * Vec3(1, 2, 3), Vec3(1, 3, -2));
}

TEST(Transform, EulerOrderSaysWhichAxisComesFirst) {
  // x first takes y to z, which z leaves alone; z first takes y to -x.
  EXPECT_EQ(rotation_matrix(Vec3(90, 0, 90), EulerOrder::xyz) * Vec3::UnitY(), Vec3::UnitZ());
  EXPECT_EQ(rotation_matrix(Vec3(90, 0, 90), EulerOrder::zyx) * Vec3::UnitY(), -Vec3::UnitX());
  const Mat3 turned = rotation_matrix(Vec3(10, 20, 30), EulerOrder::yzx);
  const auto about = [](int axis, double degrees) {
    return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Vec3::Unit(axis)).toRotationMatrix();
  };
  EXPECT_LT((turned - about(0, 10) * about(2, 30) * about(1, 20)).norm(), 1e-14);
}

TEST(Transform, UpRotationTakesUpToUpAndIsProper) {
  for (const Axis from : {Axis::x, Axis::y, Axis::z}) {
    for (const Axis to : {Axis::x, Axis::y, Axis::z}) {
      const Mat3 rotation = up_rotation(from, to);
      EXPECT_EQ(rotation * geometry::axis_direction(from), geometry::axis_direction(to));
      EXPECT_NEAR(rotation.determinant(), 1, 1e-15);
    }
  }
  EXPECT_EQ(up_rotation(Axis::z, Axis::y) * Vec3(1, 2, 3), Vec3(1, 3, -2));
}

TEST(Transform, SizeMeasuresAlongTheShotsUp) {
  const Vec3 extent(2, 4, 8);
  const auto scale = [&](Axis up, SizeMeasure measure) {
    Placement placement;
    placement.up = up;
    placement.size = SizeRule{measure, 16};
    return placement_similarity(placement, extent)->scale;
  };
  EXPECT_EQ(scale(Axis::y, SizeMeasure::height), 4);
  EXPECT_EQ(scale(Axis::y, SizeMeasure::width), 8);
  EXPECT_EQ(scale(Axis::y, SizeMeasure::depth), 2);
  EXPECT_EQ(scale(Axis::z, SizeMeasure::height), 2);
  EXPECT_EQ(scale(Axis::z, SizeMeasure::depth), 4);
  EXPECT_EQ(scale(Axis::x, SizeMeasure::height), 8);
  EXPECT_EQ(scale(Axis::x, SizeMeasure::width), 4);
  EXPECT_EQ(scale(Axis::x, SizeMeasure::depth), 2);
  EXPECT_EQ(scale(Axis::x, SizeMeasure::max), 2);
}

TEST(Transform, PlacementScalesThenTurnsThenMoves) {
  Placement placement;
  placement.scale = 2;
  placement.rotate = {AxisTurn{{0, 0, 1}, 90}, AxisTurn{{1, 0, 0}, 90}};
  placement.translate = {10, 20, 30};
  const Result<Similarity> similarity = placement_similarity(placement, Vec3(1, 1, 1));
  ASSERT_TRUE(similarity);
  Points points(1, 3);
  points << 1, 2, 3;
  apply(*similarity, points);
  // (2, 4, 6) -> about z: (-4, 2, 6) -> about x: (-4, -6, 2)
  EXPECT_EQ(points.row(0), Eigen::RowVector3d(6, 14, 32));
}

TEST(Transform, NonsenseIsRefused) {
  EXPECT_FALSE(rotation_matrix(AxisTurn{{0, 0, 0}, 90}));
  EXPECT_FALSE(rotation_matrix(AxisTurn{{0, 1, 0}, std::numeric_limits<double>::quiet_NaN()}));
  Placement placement;
  placement.scale = 0;
  EXPECT_FALSE(placement_similarity(placement, Vec3(1, 1, 1)));
  placement.scale = 1;
  placement.size = SizeRule{SizeMeasure::height, 1};
  EXPECT_FALSE(placement_similarity(placement, Vec3(1, 0, 1)));
  placement.size->length = -1;
  EXPECT_FALSE(placement_similarity(placement, Vec3(1, 1, 1)));
  placement.size.reset();
  placement.rotate = {AxisTurn{{0, 0, 0}, 1}};
  EXPECT_FALSE(placement_similarity(placement, Vec3(1, 1, 1)));
}

} // namespace
} // namespace wry::scene
