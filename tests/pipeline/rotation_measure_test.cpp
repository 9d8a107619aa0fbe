#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "pipeline/measure/measure.h"
#include "sim/base/rotation.h"
#include "sim/fem/rotation_interpolation.h"
#include "sim/geometry/structured_tets.h"

namespace wry::pipeline {
namespace {

using Kind = shots::MeasureKind;
constexpr double DEGREES = 180.0 / std::numbers::pi;

/// A rod along x whose frame is turned by exp(x omega), its axis bent into the helix that fits.
struct Rod {
  SceneBody body;
  Channel positions{"position", ChannelOn::vertex, 3, ChannelStorage::float64, {}};
  Channel rotations{"microrotation", ChannelOn::vertex, 4, ChannelStorage::float64, {}};

  explicit Rod(const Vec3& omega, int cells = 48) {
    const geometry::TetMesh mesh = geometry::make_block_tets(geometry::box_block(Vec3(1.0, 0.04, 0.04)),
                                                             {{cells, 2, 2}, geometry::CellSplit::kuhn})
                                       .value();
    body.rest_positions = mesh.vertices;
    body.tets = mesh.tets;
    for (Eigen::Index i = 0; i < mesh.vertices.rows(); ++i) {
      const Vec3 rest = mesh.vertices.row(i);
      const Vec4 q = quaternion_exponential(rest[0] * omega);
      const Vec3 place = axis_at(omega, rest[0]) + rodrigues(rest[0] * omega) * Vec3(0, rest[1], rest[2]);
      positions.values.insert(positions.values.end(), place.data(), place.data() + 3);
      rotations.values.insert(rotations.values.end(), q.data(), q.data() + 4);
    }
  }

  /// The integral of exp(s omega) e_x: constant curvature in the body's own frame is constant in the world too.
  static Vec3 axis_at(const Vec3& omega, double s) {
    const double rate = omega.norm();
    const Vec3 unit = omega / rate;
    const Vec3 along = unit[0] * unit;
    const Vec3 across = Vec3::UnitX() - along;
    return s * along + std::sin(rate * s) / rate * across + (1.0 - std::cos(rate * s)) / rate * unit.cross(across);
  }

  double measure(Kind kind, std::vector<Channel> more = {}, shots::MeasureAt at = shots::MeasureAt::nodes) const {
    MeasurePlan plan;
    plan.kind = kind;
    plan.at = at;
    FrameBody frame;
    frame.channels = {positions, rotations};
    frame.channels.insert(frame.channels.end(), more.begin(), more.end());
    return evaluate_measure(plan, {{body}}, {1, 0.0, {frame}});
  }
};

TEST(RotationMeasure, AHelixHasTheRadiusAndPitchOfItsCurvatureAndTorsion) {
  const Vec3 omega(2.0, 0.0, 5.0); // torsion and curvature
  const Rod rod(omega);
  EXPECT_NEAR(rod.measure(Kind::curve_radius), 5.0 / 29.0, 1e-3 * 5.0 / 29.0);
  EXPECT_NEAR(rod.measure(Kind::curve_pitch), 2.0 * std::numbers::pi * 2.0 / 29.0, 1e-3);
  EXPECT_NEAR(Rod(Vec3(0, 4, 0)).measure(Kind::curve_radius), 0.25, 1e-4);
  EXPECT_NEAR(Rod(Vec3(0, 4, 0)).measure(Kind::curve_pitch), 0.0, 1e-6);
}

TEST(RotationMeasure, TheHelixIsExactWhateverTheCellsAndHoweverTightlyItIsWound) {
  for (const int cells : {40, 48, 80, 83}) {
    for (const Vec3& omega : {Vec3(0.8, 0.0, 3.1), Vec3(4.0, 0.0, 16.0), Vec3(3.0, 11.0, 11.0)}) {
      const Rod rod(omega, cells);
      const double across = std::hypot(omega[1], omega[2]);
      const double radius = across / omega.squaredNorm();
      const double pitch = 2.0 * std::numbers::pi * omega[0] / omega.squaredNorm();
      EXPECT_NEAR(rod.measure(Kind::curve_radius), radius, 5e-4 * radius) << cells << " cells, " << omega.transpose();
      EXPECT_NEAR(rod.measure(Kind::curve_pitch), pitch, 5e-4 * pitch) << cells << " cells, " << omega.transpose();
    }
  }
}

TEST(RotationMeasure, TwistOfAnElementIsTheCurvatureTimesTheLengthOfItsCell) {
  EXPECT_NEAR(Rod(Vec3(3.0, 0, 0)).measure(Kind::element_twist_max), 3.0 / 48.0 * DEGREES, 1e-9);
}

TEST(RotationMeasure, MicrorotationsThatFollowTheMatterAreNear) {
  Rod rod(Vec3(0, 0, 2.0));
  EXPECT_LT(rod.measure(Kind::rotation_distance), 1.5);
  EXPECT_LT(rod.measure(Kind::rotation_distance, {}, shots::MeasureAt::centroid), 1.5);
  // All of them a quarter turn off:
  const Vec4 quarter = quaternion_exponential(Vec3(std::numbers::pi / 2, 0, 0));
  for (std::size_t i = 0; i + 3 < rod.rotations.values.size(); i += 4) {
    Eigen::Map<Vec4> q(rod.rotations.values.data() + i);
    q = quaternion_product(q, quarter);
  }
  EXPECT_NEAR(rod.measure(Kind::rotation_distance, {}, shots::MeasureAt::centroid), 90.0, 2.0);
  EXPECT_TRUE(std::isnan(rod.measure(Kind::rotation_distance, {}, shots::MeasureAt::points)));
}

TEST(RotationMeasure, PointsThatAreTheSphericalAverageHaveNoErrorAndOthersTheirAngle) {
  const Rod rod(Vec3(1.0, 2.0, 0.5));
  Channel points{"point_rotation", ChannelOn::tet, 16, ChannelStorage::float64, {}};
  const Eigen::Matrix4d weights = fem::quadrature_weights();
  const Vec4 off = quaternion_exponential(Vec3(0, 0.02, 0));
  for (Eigen::Index tet = 0; tet < rod.body.tets.rows(); ++tet) {
    std::array<Vec4, 4> corners;
    for (int k = 0; k < 4; ++k)
      corners[k] = Eigen::Map<const Vec4>(rod.rotations.values.data() + 4 * rod.body.tets(tet, k));
    for (int k = 0; k < 4; ++k) {
      const Vec4 row = weights.row(k);
      Vec4 q = fem::interpolate_rotation(fem::PointRotations::spherical_average, corners, {row.data(), 4});
      if (tet == 7 && k == 2)
        q = quaternion_product(off, q);
      points.values.insert(points.values.end(), q.data(), q.data() + 4);
    }
  }
  EXPECT_NEAR(rod.measure(Kind::rotation_interpolation_error, {points}), 0.02 * DEGREES, 1e-9);
  const double error = rod.measure(Kind::curvature_error, {points});
  EXPECT_GT(error, 0.0);
  EXPECT_LT(error, 0.1);
  EXPECT_TRUE(std::isnan(rod.measure(Kind::curvature_error)));
}

TEST(RotationMeasure, ReactionsSumForcesAndMomentsOfThePickedNodes) {
  SceneBody body;
  body.rest_positions.resize(2, 3);
  body.rest_positions << 0, 0, 0, 1, 0, 0;
  FrameBody frame;
  frame.channels = {{"position", ChannelOn::vertex, 3, ChannelStorage::float64, {0, 0, 0, 2, 0, 0}},
                    {"reaction_force", ChannelOn::vertex, 3, ChannelStorage::float64, {0, 5, 0, 0, 3, 0}},
                    {"reaction_torque", ChannelOn::vertex, 3, ChannelStorage::float64, {0, 0, 0.25, 0, 0, 0.5}}};
  MeasurePlan plan;
  plan.kind = Kind::reaction_force;
  plan.direction = Vec3::UnitY();
  EXPECT_DOUBLE_EQ(evaluate_measure(plan, {{body}}, {1, 0.0, {frame}}), 8.0);
  plan.kind = Kind::reaction_torque;
  plan.direction = Vec3::UnitZ();
  plan.about = Vec3::Zero();
  EXPECT_DOUBLE_EQ(evaluate_measure(plan, {{body}}, {1, 0.0, {frame}}), 2.0 * 3.0 + 0.75);
  plan.nodes = {1};
  plan.about.reset(); // the middle of the picked nodes: no arm
  EXPECT_DOUBLE_EQ(evaluate_measure(plan, {{body}}, {1, 0.0, {frame}}), 0.5);
}

} // namespace
} // namespace wry::pipeline
