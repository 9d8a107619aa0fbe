#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sim/base/rotation.h"
#include "sim/fem/rotation_interpolation.h"
#include "sim/geometry/structured_tets.h"
#include "tests/fem/micropolar_support.h"
#include "tests/fem/solid_support.h"

/// The numbers of spec §11 that are quick to compute; the others are in micropolar_numbers_long_test.cpp.
namespace wry::fem {
namespace {

using namespace test;

TEST(MicropolarNumbers, MicrorotationsOfAHeldStretchedTetAreThePolarFactor) {
  // Spec §4: at lambda = 0 and mu_c >= mu the polar factor of F is the minimiser, to 1e-6 degrees.
  for (const double ratio : {1.0, 2.0}) {
    FemPlan plan =
        plan_of(make_body(box_mesh(Vec3::Zero(), Vec3(1, 1, 1), 1, 1, 1), ElasticModel::micropolar, 2.0, 0.0));
    plan.bodies[0].material.couple_modulus_ratio = ratio;
    plan.bodies[0].material.density = 1e-6;
    plan.settings.newton_tolerance = 1e-15;
    plan.settings.max_time_step = 1.0;
    const Points& rest = plan.bodies[0].mesh->vertices;
    plan.fixed.push_back({"all", 0, {0, 1, 2, 3, 4, 5, 6, 7}, true, false, {}});
    Mat3 stretch;
    stretch << 1.5, 0.1, -0.2, 0.1, 0.8, 0.05, -0.2, 0.05, 1.2;
    const Mat3 F = rodrigues(Vec3(0.4, -0.5, 0.3)) * stretch;
    const std::unique_ptr<FemSimulation> simulation = simulate(plan);
    StateArchive archive = simulation->archive();
    for (NamedArray& array : archive) {
      for (Eigen::Index i = 0; array.name == "fem/body0/positions" && i < rest.rows(); ++i)
        Eigen::Map<Vec3>(array.values.data() + 3 * i) = F * rest.row(i).transpose();
    }
    ASSERT_TRUE(simulation->restore(archive));
    run_until(*simulation, 1.0);
    const StateArchive end = simulation->archive();
    const Vec4 expected = quaternion_of(polar_rotation(F));
    double worst = 0.0;
    for (const NamedArray& array : end) {
      for (Eigen::Index i = 0; array.name == "fem/body0/rotations" && i < rest.rows(); ++i)
        worst = std::max(worst, rotation_distance(Vec4(Eigen::Map<const Vec4>(array.values.data() + 4 * i)), expected));
    }
    worst *= 180.0 / std::numbers::pi;
    EXPECT_LT(worst, 1e-6);
    record_number("polar factor as minimiser: distance [degrees] (at most)", 1e-6, worst);
  }
}

/// The largest relative error of the discrete wryness at the points of a right-angled tet of edge h, whose nodes' and
/// points' rotations are exactly those of a field of constant wryness about `axis` along x.
double patch_error(double twist, const Vec3& axis) {
  Eigen::Matrix<double, 4, 3> corners;
  corners << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  Eigen::Matrix<double, 4, 3> gradients;
  gradients << -1, -1, -1, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  const auto rotation_at = [&](double x) { return quaternion_exponential(x * twist * axis); };
  std::array<Vec4, 4> nodes;
  for (int k = 0; k < 4; ++k)
    nodes[k] = rotation_at(corners(k, 0));
  Mat3 exact = Mat3::Zero();
  exact.col(0) = twist * axis; // the axis is the same in every material frame of this field
  const Eigen::Matrix4d weights = quadrature_weights();
  double worst = 0.0;
  for (int p = 0; p < 4; ++p) {
    const double x = weights.row(p) * corners.col(0);
    worst = std::max(worst, (wryness(rotation_at(x), nodes, gradients) - exact).norm() / exact.norm());
  }
  return worst;
}

TEST(MicropolarNumbers, TheWrynessOfAPatchErrsByTheSquareOfItsTwist) {
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0.6, 0, 0.8)}) {
    const double coarse = patch_error(0.2, axis);
    record_number("wryness patch error over (|Gamma| h)^2", 0.027, coarse / 0.04);
    record_number("its ratio on halving", 4.0, coarse / patch_error(0.1, axis));
    EXPECT_NEAR(coarse / (0.027 * 0.2 * 0.2), 1.0, 0.05);
    EXPECT_NEAR(coarse / patch_error(0.1, axis), 4.0, 0.05);
  }
}

TEST(MicropolarNumbers, DifferentiatingTheSphericalAverageGivesConstantWrynessExactly) {
  std::array<Vec4, 4> nodes;
  const double along[] = {0.0, 1.0, 0.0, 0.0};
  for (int k = 0; k < 4; ++k)
    nodes[k] = quaternion_exponential(along[k] * Vec3(0.3, 0.2, -0.4));
  Eigen::Matrix<double, 4, 3> gradients;
  gradients << -1, -1, -1, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  const double weights[] = {0.1, 0.2, 0.3, 0.4};
  const Mat3 gamma = spherical_wryness(nodes, weights, gradients);
  EXPECT_LT((gamma.col(0) - Vec3(0.3, 0.2, -0.4)).norm(), 1e-7);
  EXPECT_LT(gamma.rightCols<2>().norm(), 1e-7);
}

TEST(MicropolarNumbers, TheWrynessOfTheSphericalAverageIsConfirmedByDifferences) {
  std::array<Vec4, 4> nodes;
  const Vec3 turns[] = {{0.1, -0.2, 0.3}, {0.7, 0.4, -0.1}, {-0.3, 0.5, 0.2}, {0.2, 0.1, 0.9}};
  for (int k = 0; k < 4; ++k)
    nodes[k] = quaternion_exponential(turns[k]);
  Eigen::Matrix<double, 4, 3> gradients;
  gradients << -1.5, -1, -2, 1, 0.5, 0, 0.5, 1, -0.5, 0, -0.5, 2.5;
  const std::array<double, 4> weights = {0.1, 0.2, 0.3, 0.4};
  const Mat3 gamma = spherical_wryness(nodes, weights, gradients);
  for (int j = 0; j < 3; ++j) {
    constexpr double STEP = 1e-4;
    const auto average = [&](double by) {
      std::array<double, 4> moved = weights;
      for (int k = 0; k < 4; ++k)
        moved[k] += by * gradients(k, j);
      return spherical_average(nodes, moved);
    };
    const Vec4 slope = (average(STEP) - average(-STEP)) / (2.0 * STEP);
    const Vec3 expected = 2.0 * quaternion_product(quaternion_conjugate(average(0.0)), slope).tail<3>();
    EXPECT_LT((gamma.col(j) - expected).norm(), 1e-7);
  }
}

TEST(MicropolarNumbers, ACylinderResistsTorsionByTheLengthScale) {
  // Spec §11: K over that of the classical shaft, extrapolated from 4 and 8 cells across at second order.
  struct Row {
    double length_scale, exact;
  };
  for (const Row& row : {Row{0.2, 1.11720}, Row{1.0, 3.74528}, Row{5.0, 67.77596}}) {
    const double coarse = torsion_ratio(row.length_scale, 4);
    const double fine = torsion_ratio(row.length_scale, 8);
    EXPECT_NEAR((4.0 * fine - coarse) / 3.0, row.exact, 0.01 * row.exact) << row.length_scale;
    EXPECT_LT(std::abs(fine - row.exact), 0.4 * std::abs(coarse - row.exact)) << row.length_scale;
  }
}

} // namespace
} // namespace wry::fem
