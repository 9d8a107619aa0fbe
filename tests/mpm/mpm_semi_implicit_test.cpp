#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/mpm/mpm_support.h"

namespace wry::mpm {
namespace {

constexpr double CELL = 0.05;

/// Stiff fibres along a skew direction, a hundred times stiffer than what is between them.
Material fibres(double ratio = 100.0) {
  Material material;
  material.name = "fibres";
  material.youngs_modulus = {1e4, 1e4, 1e4 * ratio};
  material.poisson_ratio.yz = material.poisson_ratio.xz = 0.0;
  return material;
}

/// A block of fibres that stretches, shears and spins in free flight.
MpmPlan wobbling_block(const Material& material = fibres(), Transfer transfer = Transfer::gradient) {
  MpmPlan plan;
  plan.gravity = Vec3::Zero();
  plan.settings.cell = CELL;
  plan.settings.precision = Precision::f64;
  plan.settings.transfer = transfer;
  plan.bodies.push_back(box_of_matter(Vec3(0, 0, 0), Vec3(0.25, 0.2, 0.2), CELL, 8, material));
  plan.bodies[0].frame = Eigen::AngleAxisd(0.7, Vec3(1, 2, 0.5).normalized()).toRotationMatrix();
  plan.bodies[0].velocity_field = [](const Vec3& x) {
    const Vec3 r = x - Vec3(0.125, 0.1, 0.1);
    return Vec3(0.3 * r.y() + 0.2 * r.x(), -0.4 * r.x() + 0.1 * r.z(), 0.2 * r.z());
  };
  return plan;
}

MpmPlan with(MpmPlan plan, SemiImplicit settings) {
  plan.settings.semi_implicit = settings;
  return plan;
}

double step_of(const MpmPlan& plan) {
  return make(plan)->bound().dt;
}

/// Positions after this long, in this many equal steps.
Points run(MpmPlan plan, double end, int steps) {
  plan.settings.time_step = end / steps;
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
  int made = 0;
  while (simulation->time() < end) {
    const Result<StepStats> stats = simulation->step(end);
    EXPECT_TRUE(stats.ok()) << stats.error().message;
    if (!stats)
      return {};
    ++made;
  }
  EXPECT_EQ(made, steps);
  return channel_of(*simulation, 0, "position");
}

double distance(const Points& a, const Points& b) {
  return (a - b).norm() / std::sqrt(static_cast<double>(a.rows()));
}

TEST(SemiImplicit, KeepsMomentumAndSpinWhereverTheSolveIsStopped) {
  for (const Transfer transfer : {Transfer::gradient, Transfer::mls}) {
    for (const double tolerance : {0.5, 1e-6}) {
      const auto simulation =
          make(with(wobbling_block(fibres(), transfer), {.implicitness = 0.5, .damping = 0.3, .tolerance = tolerance}));
      const Totals before = simulation->totals();
      run_to(*simulation, 0.3);
      const Totals after = simulation->totals();
      EXPECT_GT(after.elastic_energy, 1e-3 * after.kinetic_energy); // it was strained
      EXPECT_LT((after.momentum - before.momentum).norm(), 1e-10);
      EXPECT_LT((after.angular_momentum - before.angular_momentum).norm(), 1e-10 * before.angular_momentum.norm());
    }
  }
}

/// A free bar of fibres along it, 8 cells long, that begins to swing in its first mode.
MpmPlan swinging_bar() {
  constexpr double LENGTH = 8 * CELL, OFFSET = 0.5 * CELL;
  MpmPlan plan;
  plan.gravity = Vec3::Zero();
  plan.settings.cell = CELL;
  plan.settings.precision = Precision::f64;
  plan.bodies.push_back(
      box_of_matter(Vec3::Constant(OFFSET), Vec3(LENGTH + OFFSET, 2.5 * CELL, 2.5 * CELL), CELL, 8, fibres()));
  plan.bodies[0].frame = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitY()).toRotationMatrix();
  plan.bodies[0].velocity_field = [](const Vec3& x) {
    return Vec3(1e-3 * std::cos(std::numbers::pi * (x.x() - OFFSET) / LENGTH), 0, 0);
  };
  return plan;
}

TEST(SemiImplicit, ComesToTheExplicitStepWithTheSquareOfTheTimeStepAndWithDampingWithItself) {
  const double end = 0.015; // more than half a period
  const int steps = 2 * static_cast<int>(std::ceil(end / step_of(swinging_bar())));
  // Against the explicit scheme with the same steps, so that nothing but the implicit part is left.
  const auto difference = [&](double damping, int times) {
    const SemiImplicit settings{.damping = damping, .tolerance = 1e-9};
    return distance(run(with(swinging_bar(), settings), end, steps * times), run(swinging_bar(), end, steps * times));
  };
  EXPECT_NEAR(std::log2(difference(0.0, 1) / difference(0.0, 2)), 2.0, 0.2);
  EXPECT_NEAR(std::log2(difference(1.0, 1) / difference(1.0, 2)), 1.0, 0.2);
}

TEST(SemiImplicit, GivesNoEnergyFarBeyondTheExplicitLimit) {
  const MpmPlan plan = with(wobbling_block(fibres(1e4)), {.courant = 8.0});
  EXPECT_GT(step_of(plan), 15.0 * step_of(wobbling_block(fibres(1e4))));
  const auto simulation = make(plan);
  const double put_in = simulation->totals().kinetic_energy;
  while (simulation->time() < 0.1) {
    ASSERT_TRUE(simulation->step(0.1).ok());
    const Totals now = simulation->totals();
    ASSERT_LE(now.kinetic_energy + now.elastic_energy, 1.005 * put_in) << simulation->time();
  }
}

TEST(SemiImplicit, WithoutDampingItNeitherGrowsNorLosesASlowSwing) {
  // Fibres stretched by a step's dt v hold z times the energy that they should, and no more later than at once.
  const auto energies = [](double damping) {
    const auto simulation =
        make(with(wobbling_block(fibres(1e4)), {.courant = 8.0, .implicitness = 0.5, .damping = damping}));
    const double put_in = simulation->totals().kinetic_energy;
    double most[2] = {0.0, 0.0};
    while (simulation->time() < 0.2) {
      EXPECT_TRUE(simulation->step(0.2).ok());
      const Totals now = simulation->totals();
      double& of_half = most[simulation->time() > 0.1 ? 1 : 0];
      of_half = std::max(of_half, (now.kinetic_energy + now.elastic_energy) / put_in);
    }
    return std::pair(most[0], most[1]);
  };
  const auto [early, late] = energies(0.0);
  EXPECT_LT(late, early);
  EXPECT_GT(early, 1.5); // that is why damping is the default
  EXPECT_LT(energies(1.0).first, 1.005);
}

TEST(SemiImplicit, StepsAreAsLongAsItsCourantNumberSays) {
  const MpmPlan plan = wobbling_block();
  const Material material = plan.bodies[0].material;
  const double speed = compile_material(material)->sound_speed;
  const StepBound bound = make(with(plan, {.courant = 3.0}))->bound();
  EXPECT_EQ(bound.limit, StepLimit::wave);
  EXPECT_NEAR(bound.dt, 3.0 * CELL / speed, 1e-9 * bound.dt);
  // Matter still crosses no more than mpm.courant of a cell.
  MpmPlan fast = with(plan, {.courant = 3.0});
  fast.bodies[0].initial_velocity = Vec3(100, 0, 0);
  const StepBound limited = make(std::move(fast))->bound();
  EXPECT_EQ(limited.limit, StepLimit::speed);
  EXPECT_LE(limited.dt, 0.4 * CELL / 100.0);
}

TEST(SemiImplicit, BlockOnASlopeSlidesAsCoulombSays) {
  const double angle = std::numbers::pi / 6.0;
  for (const double friction : {0.3, 0.8}) {
    MpmPlan plan;
    plan.settings.cell = 0.02;
    plan.settings.precision = Precision::f64;
    plan.settings.semi_implicit = SemiImplicit{};
    plan.gravity = 9.81 * Vec3(std::sin(angle), 0, -std::cos(angle));
    Material stiff = fibres();
    stiff.density = 1500.0;
    stiff.youngs_modulus = {2e5, 2e5, 2e7};
    plan.bodies.push_back(box_of_matter(Vec3(-0.1, -0.06, 0), Vec3(0.1, 0.06, 0.06), 0.02, 8, stiff));
    plan.bodies[0].frame = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitY()).toRotationMatrix(); // along x
    auto floor = std::make_shared<scene::Collider>();
    floor->shape = scene::PlaneObstacle{Vec3::Zero(), Vec3::UnitZ()};
    floor->friction = friction;
    plan.colliders.push_back(floor);
    const auto simulation = make(std::move(plan));
    run_to(*simulation, 0.15);
    const double acceleration = std::max(0.0, 9.81 * (std::sin(angle) - friction * std::cos(angle)));
    const Points x = channel_of(*simulation, 0, "position");
    EXPECT_NEAR(x.col(0).mean(), 0.5 * acceleration * 0.0225,
                friction < 0.5 ? 0.07 * 0.5 * acceleration * 0.0225 : 1e-3)
        << friction;
    EXPECT_GT(x.col(2).minCoeff(), -1e-3);
    EXPECT_LT(x.col(2).maxCoeff(), 0.065);
  }
}

TEST(SemiImplicit, AStickyWallHoldsABeamOfFibres) {
  MpmPlan plan;
  plan.gravity = Vec3(0, 0, -9.81);
  plan.settings.cell = CELL;
  plan.settings.semi_implicit = SemiImplicit{.courant = 6.0};
  plan.bodies.push_back(box_of_matter(Vec3(-0.1, 0, 0), Vec3(0.5, 0.1, 0.15), CELL, 8, fibres(1e4)));
  plan.bodies[0].frame = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitY()).toRotationMatrix(); // along x
  auto wall = std::make_shared<scene::Collider>();
  wall->shape = scene::PlaneObstacle{Vec3::Zero(), Vec3::UnitX()};
  wall->contact = scene::ColliderContact::sticky;
  plan.colliders.push_back(wall);
  const Points start = *plan.bodies[0].positions;
  const auto simulation = make(std::move(plan));
  run_to(*simulation, 0.3);
  const Points x = channel_of(*simulation, 0, "position");
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    EXPECT_LT((x.row(i) - start.row(i)).norm(), start(i, 0) < 0.0 ? 5e-3 : 0.3);
    EXPECT_GT(x(i, 2), -0.25); // free, it would have fallen .44 m
  }
}

class SemiImplicitBits : public ::testing::TestWithParam<Precision> {};
INSTANTIATE_TEST_SUITE_P(Both, SemiImplicitBits, ::testing::Values(Precision::f32, Precision::f64));

TEST_P(SemiImplicitBits, AreTheSameOnAnyNumberOfThreadsAndAfterACheckpoint) {
  MpmPlan plan = column_plan(column_material(), GetParam());
  plan.settings.semi_implicit = SemiImplicit{.courant = 2.0};
  plan.bodies[0].initial_velocity = Vec3(0.8, -0.3, 0.0);
  const auto first = make(plan, 1);
  run_to(*first, 0.02);
  const StateArchive middle = first->archive();
  run_to(*first, 0.04);
  const auto second = make(plan, 3);
  ASSERT_TRUE(second->restore(middle).ok());
  run_to(*second, 0.04);
  const StateArchive a = first->archive(), b = second->archive();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    EXPECT_TRUE(a[i].values == b[i].values) << a[i].name;
}

} // namespace
} // namespace wry::mpm
