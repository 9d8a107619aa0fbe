#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/mpm/mpm_support.h"

namespace wry::mpm {
namespace {

Material elastic() {
  Material material;
  material.name = "elastic";
  material.youngs_modulus = {1e4, 1e4, 1e4};
  material.density = 1000.0;
  return material;
}

MpmPlan flying_box(Precision precision, Transfer transfer) {
  constexpr double CELL = 0.1;
  MpmPlan plan;
  plan.settings.cell = CELL;
  plan.settings.precision = precision;
  plan.settings.transfer = transfer;
  plan.bodies.push_back(box_of_matter(Vec3(0, 0, 0), Vec3(0.6, 0.4, 0.5), CELL, 8, elastic()));
  plan.bodies[0].initial_velocity = Vec3(1.0, 0.5, -0.25);
  return plan;
}

TEST(FreeFall, FollowsTheParabolaToRoundOff) {
  for (const Transfer transfer : {Transfer::gradient, Transfer::mls}) {
    MpmPlan plan = flying_box(Precision::f64, transfer);
    plan.gravity = Vec3(0.3, -9.81, 1.0);
    const Points start = *plan.bodies[0].positions;
    const Vec3 gravity = plan.gravity;
    const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
    // Symplectic Euler falls by g dt^2 n(n+1)/2 in n steps.
    double fallen = 0.0;
    double speed = 0.0;
    while (simulation->time() < 0.5) {
      const Result<StepStats> stats = simulation->step(0.5);
      ASSERT_TRUE(stats.ok()) << stats.error().message;
      speed += stats->dt;
      fallen += speed * stats->dt;
    }
    const Points now = channel_of(*simulation, 0, "position");
    double worst = 0.0;
    for (Eigen::Index i = 0; i < now.rows(); ++i) {
      const Vec3 expected = start.row(i).transpose() + 0.5 * Vec3(1.0, 0.5, -0.25) + fallen * gravity;
      worst = std::max(worst, (now.row(i).transpose() - expected).norm());
    }
    EXPECT_LT(worst, 1e-10);
  }
}

TEST(Momentum, OfAStrainedSpinningBlockIsKept) {
  for (const Transfer transfer : {Transfer::gradient, Transfer::mls}) {
    MpmPlan plan = flying_box(Precision::f64, transfer);
    plan.gravity = Vec3::Zero();
    plan.bodies[0].velocity_field = [](const Vec3& x) {
      return Vec3(Vec3(0.4, -0.8, 1.0).cross(x - Vec3(0.3, 0.2, 0.25)) + 0.5 * Vec3(x.y(), 0.3 * x.z(), -x.x()));
    };
    const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
    const Totals before = simulation->totals();
    run_to(*simulation, 0.5);
    const Totals after = simulation->totals();
    EXPECT_GT(after.elastic_energy, 1e-4 * after.kinetic_energy); // it was strained
    EXPECT_LT((after.momentum - before.momentum).norm(), 1e-10 * before.momentum.norm());
    EXPECT_LT((after.angular_momentum - before.angular_momentum).norm(), 1e-10 * before.angular_momentum.norm());
  }
}

TEST(Energy, StoredInAnElasticBlockNeverExceedsWhatWasPutIn) {
  MpmPlan plan = flying_box(Precision::f64, Transfer::gradient);
  plan.gravity = Vec3::Zero();
  plan.bodies[0].initial_velocity = Vec3::Zero();
  plan.bodies[0].velocity_field = [](const Vec3& x) { return Vec3(0.3 * (x - Vec3(0.3, 0.2, 0.25))); };
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
  const double put_in = simulation->totals().kinetic_energy;
  double most = 0.0;
  while (simulation->time() < 3.0) {
    ASSERT_TRUE(simulation->step(3.0).ok());
    most = std::max(most, simulation->totals().elastic_energy);
    ASSERT_LE(most, 1.005 * put_in) << simulation->time();
  }
  EXPECT_GT(most, 0.5 * put_in); // it did swing
}

TEST(Totals, OfARigidSpinAreThoseOfABody) {
  MpmPlan plan = flying_box(Precision::f64, Transfer::gradient);
  plan.gravity = Vec3::Zero();
  plan.bodies[0].initial_velocity = Vec3::Zero();
  const Vec3 spin(0.2, 0.5, -1.0);
  plan.bodies[0].velocity_field = [spin](const Vec3& x) { return Vec3(spin.cross(x - Vec3(0.3, 0.2, 0.25))); };
  plan.settings.cell = 0.02;
  plan.bodies[0].positions = box_of_matter(Vec3(0, 0, 0), Vec3(0.6, 0.4, 0.5), 0.1, 512, elastic()).positions;
  plan.bodies[0].particle_volume = 0.12 / static_cast<double>(plan.bodies[0].positions->rows());
  const double mass = 120.0;
  const Vec3 inertia = mass / 12.0 * Vec3(0.16 + 0.25, 0.36 + 0.25, 0.36 + 0.16);
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
  const Totals totals = simulation->totals();
  EXPECT_NEAR(totals.mass, mass, 1e-9);
  EXPECT_LT((totals.angular_momentum - inertia.cwiseProduct(spin)).norm(), 0.01 * inertia.norm());
}

} // namespace
} // namespace wry::mpm
