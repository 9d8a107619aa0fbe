#include <cmath>
#include <numbers>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "sim/base/rotation.h"
#include "sim/mpm/grains/dice.h"
#include "sim/mpm/matter/orientation.h"
#include "tests/mpm/matter_tiles_support.h"

namespace wry::mpm {
namespace {

/// v_x = gamma y.
Mat3 shear_flow(double gamma) {
  Mat3 L = Mat3::Zero();
  L(0, 1) = gamma;
  return L;
}

/// Time until a grain in the x-y plane has turned once (p and -p are the same grain, so twice half a turn).
double period(double length_over_width, double gamma, double dt) {
  const double l = jeffery_shape(length_over_width);
  Vec3 p = Vec3::UnitX();
  double turned = 0.0, time = 0.0;
  for (;;) {
    const Vec3 next = turn_direction(p, shear_flow(gamma), l, dt);
    const double step = std::atan2(next.x() * p.y() - next.y() * p.x(), next.dot(p)); // clockwise
    if (turned + step >= 2.0 * std::numbers::pi)
      return time + dt * (2.0 * std::numbers::pi - turned) / step;
    turned += step;
    time += dt;
    p = next;
  }
}

TEST(Orientation, AGrainTurnsWithJefferysPeriod) {
  // A full turn; the direction of a grain without ends repeats after half of it, 16.336 / gamma for r = 5.
  for (const double r : {0.2, 2.0, 5.0}) {
    const double gamma = 3.0, expected = 2.0 * std::numbers::pi * (r + 1.0 / r) / gamma;
    EXPECT_NEAR(period(r, gamma, 2e-3), expected, 1e-3 * expected) << r;
  }
}

TEST(Orientation, APureStretchTurnsAGrainAsTheExponentialDoesHoweverLong) {
  Mat3 D = Mat3::Zero();
  D.diagonal() << 1.0, -0.2, -0.8;
  const Vec3 p = Vec3(0.3, 0.8, 0.5).normalized();
  const double l = jeffery_shape(5.0);
  for (const double dt : {1e-6, 1e-3, 0.1, 0.4, 0.45, 3.0}) { // by the series up to .42, by eigenvectors beyond
    const Vec3 expected = (l * dt * D.diagonal()).array().exp().matrix().cwiseProduct(p).normalized();
    EXPECT_LT((turn_direction(p, D, l, dt) - expected).norm(), 1e-15) << dt;
  }
}

TEST(Orientation, AGrainsTurnIsSecondOrderInTime) {
  const double l = jeffery_shape(5.0);
  const auto after = [&](int steps) {
    Vec3 p = Vec3(0.3, 0.8, 0.5).normalized();
    for (int i = 0; i < steps; ++i)
      p = turn_direction(p, shear_flow(1.0), l, 4.0 / steps);
    return p;
  };
  const Vec3 exact = after(8192);
  const double coarse = (after(64) - exact).norm(), fine = (after(128) - exact).norm();
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.1);
}

/// Second moment in the world after a shear of gamma in `steps` steps of frame and reorientation.
Mat3 closure_after(double gamma, int steps) {
  const double dt = gamma / steps, l = jeffery_shape(5.0);
  const Mat3 L = shear_flow(1.0), D = 0.5 * (L + L.transpose());
  Mat3 Q = Mat3::Identity(), Pi = Mat3::Identity() / 3.0;
  const Vec3 spin(0.0, 0.0, -0.5);
  for (int i = 0; i < steps; ++i) {
    const Mat3 middle = rodrigues(0.5 * dt * spin) * Q, next = rodrigues(dt * spin) * Q;
    const DiagonalFrame turned = reorient(evolve_second_moment(Pi, middle.transpose() * D * middle, l, dt));
    Q = next * turned.turn;
    Pi = turned.second_moment;
  }
  return Q * Pi * Q.transpose();
}

TEST(Orientation, TheClosureAlignsAsDocumentedAndSecondOrderInTime) {
  EXPECT_NEAR(closure_after(2.0, 4000)(0, 0), 0.701, 5e-4);
  const Mat3 exact = closure_after(2.0, 20000);
  const double coarse = (closure_after(2.0, 80) - exact).norm(), fine = (closure_after(2.0, 160) - exact).norm();
  EXPECT_LT(coarse, 5e-5);
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.25);
}

TEST(Orientation, AnEnsembleOfGrainsAlignsLessThanTheClosure) {
  Dice dice(3);
  const double l = jeffery_shape(5.0);
  constexpr int GRAINS = 20'000, STEPS = 60;
  Mat3 Pi = Mat3::Zero();
  for (int i = 0; i < GRAINS; ++i) {
    Vec3 p = dice.direction();
    for (int step = 0; step < STEPS; ++step)
      p = turn_direction(p, shear_flow(1.0), l, 2.0 / STEPS);
    Pi += p * p.transpose() / GRAINS;
  }
  EXPECT_NEAR(Pi(0, 0), 0.565, 0.01);
}

TEST(Orientation, SecondMomentsStayPositiveForAnyStep) {
  Mat3 D = Mat3::Zero();
  D.diagonal() << 40.0, -25.0, -15.0;
  const Mat3 Pi = evolve_second_moment(Mat3::Identity() / 3.0, D, 0.9, 1.0);
  EXPECT_NEAR(Pi.trace(), 1.0, 1e-12);
  EXPECT_GE(Eigen::SelfAdjointEigenSolver<Mat3>(Pi).eigenvalues()[0], 0.0);
  EXPECT_NEAR(Pi(0, 0), 1.0, 1e-9);
}

TEST(Orientation, FramesHaveNoReasonToTurnBetweenEqualAxes) {
  Mat3 Pi = Mat3::Identity() / 3.0;
  Pi(0, 1) = Pi(1, 0) = 4e-4;
  EXPECT_EQ(reorient(Pi).turn, Mat3::Identity());
  Pi(0, 1) = Pi(1, 0) = 6e-4;
  EXPECT_NE(reorient(Pi).turn, Mat3::Identity());
}

TEST(Orientation, ReorientingNeverSwapsLabels) {
  for (double angle = 0.0; angle < 0.78; angle += 0.05) {
    const Mat3 R = rodrigues(angle * Vec3(0.0, 0.0, 1.0));
    const Mat3 Pi = R * Vec3(0.2, 0.3, 0.5).asDiagonal() * R.transpose();
    const DiagonalFrame turned = reorient(Pi);
    EXPECT_NEAR(turned.second_moment(0, 0), 0.2, 1e-12) << angle;
    EXPECT_LT((turned.turn - R).norm(), 1e-12) << angle;
  }
}

TEST(Orientation, TheKernelTurnsGrainsWithTheFlow) {
  Material material;
  material.plasticity = Plasticity::drucker_prager;
  material.friction_angle = 0.6;
  material.reorientation.emplace();
  material.reorientation->length_over_width = 5.0;
  std::vector<test::Sample> samples(1);
  const int steps = 2000;
  for (int i = 0; i < steps; ++i) {
    samples[0].L = shear_flow(1.0);
    samples[0].F = Mat3::Identity();
    test::run_kernel<double>(material, native_isa(), 2.0 / steps, samples);
  }
  const Mat3 Q = rotation_matrix(samples[0].frame);
  EXPECT_NEAR((Q * samples[0].second_moment * Q.transpose())(0, 0), 0.701, 2e-3);
}

} // namespace
} // namespace wry::mpm
