#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/extreme_table.h"
#include "tests/mpm/mpm_support.h"

namespace wry::mpm {
namespace {

constexpr double CELL = 0.05;

Material elastic(double modulus = 1e5) {
  Material material;
  material.name = "elastic";
  material.youngs_modulus = {modulus, modulus, modulus};
  return material;
}

MpmPlan one_box(const Material& material, Precision precision = Precision::f64, double per_cell = 8) {
  MpmPlan plan;
  plan.gravity = Vec3(0, 0, -9.81);
  plan.settings.cell = CELL;
  plan.settings.precision = precision;
  plan.bodies.push_back(box_of_matter(Vec3(0, 0, 0), Vec3(0.2, 0.2, 0.2), CELL, per_cell, material));
  auto floor = std::make_shared<scene::Collider>();
  floor->name = "floor";
  floor->shape = scene::PlaneObstacle{Vec3::Zero(), Vec3::UnitZ()};
  plan.colliders.push_back(floor);
  return plan;
}

/// A case of the extreme suite that ran to its end, or (with words) that was refused.
void note(const std::string& name, int steps, const std::string& said = "", const char* outcome = "holds") {
  wry::test::note_extreme("particles", name, {said.empty() ? outcome : "refuses", steps, 0, 0, 0.0, said});
}

/// The box is where it should be: on the floor, not thrown about.
void expect_at_rest_on_floor(const MpmSimulation& simulation) {
  const Points x = channel_of(simulation, 0, "position");
  ASSERT_TRUE(x.allFinite());
  EXPECT_GT(x.col(2).minCoeff(), -CELL);
  EXPECT_LT(x.col(2).maxCoeff(), 0.25);
  EXPECT_LT(x.leftCols(2).cwiseAbs().maxCoeff(), 0.3);
}

TEST(Extremes, StiffnessAlongTheFibreFrom1To1e6Times) {
  double softest = 0.0;
  for (const double ratio : {1.0, 1e2, 1e4, 1e6}) {
    Material material = elastic(1e4);
    material.youngs_modulus = {1e4, 1e4, 1e4 * ratio};
    material.poisson_ratio.yz = material.poisson_ratio.xz = 0.0;
    const std::unique_ptr<MpmSimulation> simulation = make(one_box(material));
    const double dt = simulation->bound().dt;
    softest = ratio == 1.0 ? dt : softest;
    // Steps shrink with the root of the stiffness, and not more.
    EXPECT_LT(dt, 1.25 * softest / std::sqrt(ratio));
    EXPECT_GT(dt, 0.75 * softest / std::sqrt(ratio));
    for (int step = 0; step < 200; ++step) {
      const Result<StepStats> stats = simulation->step(10.0);
      ASSERT_TRUE(stats.ok()) << ratio << ": " << stats.error().message;
    }
    note(fmt::format("{:g} times stiffer along the fibre", ratio), 200);
    expect_at_rest_on_floor(*simulation);
  }
}

TEST(Extremes, StepsOf1To10TimesTheLimitAreCutAndSaidSo) {
  const double stable = make(one_box(elastic()))->bound().dt;
  for (const double factor : {0.5, 1.0, 2.0, 10.0}) {
    MpmPlan plan = one_box(elastic());
    plan.settings.time_step = factor * stable;
    const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
    const Result<StepStats> stats = simulation->step(10.0);
    ASSERT_TRUE(stats.ok());
    EXPECT_NEAR(stats->given_over_stable, factor, 1e-9);
    EXPECT_LE(stats->dt, stable * (1.0 + 1e-9));
    EXPECT_EQ(stats->limit, factor <= 1.0 ? StepLimit::given : StepLimit::wave);
    const int steps = run_to(*simulation, 0.2);
    note(fmt::format("dt of {:g} times the limit", factor), steps, "", factor > 1.0 ? "shorter steps" : "holds");
    expect_at_rest_on_floor(*simulation);
  }
}

TEST(Extremes, From1To1000ParticlesPerCell) {
  for (const double per_cell : {1.0, 8.0, 64.0, 1000.0}) {
    const std::unique_ptr<MpmSimulation> simulation = make(one_box(elastic(), Precision::f32, per_cell));
    const double end = per_cell > 100 ? 0.02 : 0.2;
    const int steps = run_to(*simulation, end);
    note(fmt::format("{:g} per cell", per_cell), steps);
    expect_at_rest_on_floor(*simulation);
    EXPECT_NEAR(simulation->totals().mass, 8.0, 1e-3);
  }
}

TEST(Extremes, OneParticleFallsAndLands) {
  MpmPlan plan = one_box(elastic());
  Points alone(1, 3);
  alone << 0.111, 0.222, 0.3;
  plan.bodies[0].positions = std::make_shared<const Points>(alone);
  plan.bodies[0].particle_volume = 1e-6;
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
  run_to(*simulation, 0.2);
  EXPECT_NEAR(channel_of(*simulation, 0, "position")(0, 2), 0.3 - 0.5 * 9.81 * 0.04, 0.01);
  const int steps = run_to(*simulation, 1.0);
  note("one particle", steps);
  EXPECT_NEAR(channel_of(*simulation, 0, "position")(0, 2), 0.0, CELL);
}

TEST(Extremes, NoParticleIsAnErrorThatNamesTheBody) {
  MpmPlan plan = one_box(elastic());
  plan.bodies[0].positions = std::make_shared<const Points>(Points(0, 3));
  const Result<std::unique_ptr<MpmSimulation>> made = MpmSimulation::create(std::move(plan), 1, native_isa());
  ASSERT_FALSE(made.ok());
  note("no particle", 0, made.error().message);
  EXPECT_NE(made.error().message.find("body box"), std::string::npos);
}

TEST(Extremes, ParticleThatLeavesGoesOnForEver) {
  MpmPlan plan = one_box(elastic(), Precision::f32);
  plan.gravity = Vec3::Zero();
  Points points = *plan.bodies[0].positions;
  points.row(0) << 5, 5, 5; // alone
  plan.bodies[0].positions = std::make_shared<const Points>(points);
  plan.bodies[0].initial_velocity = Vec3(3, -2, 1);
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
  const int steps = run_to(*simulation, 1.0);
  note("a particle that leaves", steps);
  const Vec3 now = channel_of(*simulation, 0, "position").row(0);
  EXPECT_LT((now - Vec3(8, 3, 6)).norm(), 1e-4);
}

TEST(Extremes, ParticleAt1e9MetresIsAsGoodAsAnother) {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    MpmPlan plan = one_box(elastic(), precision);
    Points points = *plan.bodies[0].positions;
    points.row(0) << 1e9, -1e9, 1e9;
    plan.bodies[0].positions = std::make_shared<const Points>(points);
    const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
    const int steps = run_to(*simulation, 0.1);
    note(precision == Precision::f32 ? "a particle at 1e9 m, f32" : "a particle at 1e9 m, f64", steps);
    const Points now = channel_of(*simulation, 0, "position");
    EXPECT_LT((now.row(0) - points.row(0)).norm(), 0.06);
    EXPECT_LT(now.bottomRows(now.rows() - 1).cwiseAbs().maxCoeff(), 0.3);
    EXPECT_LT(simulation->memory_bytes(), 10u << 20);
  }
}

TEST(Extremes, ParticleThatIsNowhereIsAnErrorThatNamesIt) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
    MpmPlan plan = one_box(elastic());
    Points points = *plan.bodies[0].positions;
    points(7, 1) = bad;
    plan.bodies[0].positions = std::make_shared<const Points>(points);
    const Result<std::unique_ptr<MpmSimulation>> made = MpmSimulation::create(std::move(plan), 1, native_isa());
    ASSERT_FALSE(made.ok());
    note(fmt::format("a particle at {:g} m", bad), 0, made.error().message);
    EXPECT_NE(made.error().message.find("particle 7"), std::string::npos) << made.error().message;
  }
}

TEST(Extremes, ParticlesExactlyOnTheFloorOnNodesAndBetweenBlocksStayWhereTheyAre) {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    MpmPlan plan = one_box(elastic(), precision);
    plan.gravity = Vec3::Zero();
    Points points(5, 3);
    points << 0, 0, 0,                // on the floor and on a node
        0.5 * CELL, 0.5 * CELL, 0,    // on the floor, between nodes
        4 * CELL, 4 * CELL, 4 * CELL, // where eight blocks meet
        3.5 * CELL, 0, 8 * CELL,      // between the cells that belong to two blocks
        -4 * CELL, -0.5 * CELL, 4 * CELL;
    plan.bodies[0].positions = std::make_shared<const Points>(points);
    const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
    const int steps = run_to(*simulation, 0.1);
    note(precision == Precision::f32 ? "particles on the boundary, f32" : "particles on the boundary, f64", steps);
    EXPECT_EQ(channel_of(*simulation, 0, "position"), points);
  }
}

TEST(Extremes, OneKilometrePerSecondIntoTheFloor) {
  // Steel-like matter stays whole. Sand of 5e4 Pa is crushed to nothing: that is an error with place and numbers.
  for (const double modulus : {1e11, 5e4}) {
    for (const Precision precision : {Precision::f32, Precision::f64}) {
      Material material = column_material();
      material.youngs_modulus = {modulus, modulus, modulus};
      MpmPlan plan = one_box(material, precision);
      plan.bodies[0].positions = box_of_matter(Vec3(0, 0, 0.3), Vec3(0.2, 0.2, 0.5), CELL, 8, material).positions;
      plan.bodies[0].initial_velocity = Vec3(100, 0, -1000);
      const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
      Status status;
      int steps = 0;
      for (; steps < 400 && status.ok(); ++steps) {
        const Result<StepStats> stats = simulation->step(1.0);
        status = stats.ok() ? Status() : Status(stats.error());
      }
      note(fmt::format("1 km/s into the floor, E {:g} Pa, {}", modulus, precision == Precision::f32 ? "f32" : "f64"),
           steps, status.ok() ? "" : status.error().message);
      ASSERT_TRUE(modulus < 1e9 || status.ok()) << status.error().message;
      if (!status.ok()) {
        EXPECT_EQ(status.error().code, ErrorCode::solver);
        for (const char* part : {"particle", "wave speed", " m/s", "t = "})
          EXPECT_NE(status.error().message.find(part), std::string::npos) << status.error().message;
        continue;
      }
      const Points x = channel_of(*simulation, 0, "position");
      EXPECT_TRUE(x.allFinite());
      EXPECT_GT(x.col(2).minCoeff(), -CELL);
    }
  }
}

TEST(Extremes, TenSecondsOfSpinningFlightKeepTheSpin) {
  MpmPlan plan = one_box(elastic(1e4));
  plan.colliders.clear();
  plan.bodies[0].velocity_field = [](const Vec3& x) { return Vec3(Vec3(0, 0, 6.0).cross(x - Vec3::Constant(0.1))); };
  plan.bodies[0].initial_velocity = Vec3(1, 0, 49);
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
  const auto spin = [](const MpmSimulation& now) {
    const Totals t = now.totals();
    Vec3 centre = channel_of(now, 0, "position").colwise().mean();
    return Vec3(t.angular_momentum - centre.cross(t.momentum)).z();
  };
  const double before = spin(*simulation);
  const int steps = run_to(*simulation, 10.0);
  note("ten seconds of spinning flight", steps);
  EXPECT_NEAR(spin(*simulation), before, 1e-8 * std::abs(before));
  const Points x = channel_of(*simulation, 0, "position");
  const Vec3 centre = x.colwise().mean();
  EXPECT_NEAR(centre.x(), 10.1, 1e-6);
  // It is still a box of that size.
  EXPECT_LT((x.rowwise() - centre.transpose()).rowwise().norm().maxCoeff(), 0.2);
}

TEST(TurnedScene, GivesTheSameCollapseWithinDiscretisation) {
  // Everything, gravity too, is turned by 37 degrees about (1, 1, 1); the grid is not.
  const Mat3 turn = Eigen::AngleAxisd(37.0 * std::numbers::pi / 180.0, Vec3(1, 1, 1).normalized()).toRotationMatrix();
  Material material = column_material();
  material.plastic_scale = {1, 1, 1.3};
  std::array<Vec3, 2> spread;
  for (int turned = 0; turned < 2; ++turned) {
    const Mat3 rotation = turned == 1 ? turn : Mat3(Mat3::Identity());
    MpmPlan plan = column_plan(material, Precision::f64);
    plan.gravity = rotation * plan.gravity;
    plan.bodies[0].frame = rotation;
    Points points = *plan.bodies[0].positions * rotation.transpose();
    plan.bodies[0].positions = std::make_shared<const Points>(points);
    auto floor = std::make_shared<scene::Collider>();
    floor->shape = scene::PlaneObstacle{Vec3::Zero(), rotation * Vec3::UnitZ()};
    floor->contact = scene::ColliderContact::sticky;
    plan.colliders = {floor};
    const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
    const int steps = run_to(*simulation, 0.5);
    note(turned == 1 ? "a scene turned by 37 degrees about (1, 1, 1)" : "the same scene upright", steps);
    const Points x = channel_of(*simulation, 0, "position") * rotation;
    spread[static_cast<std::size_t>(turned)] =
        Vec3(quantile(x.col(0).cwiseAbs(), 0.98), quantile(x.col(1).cwiseAbs(), 0.98), quantile(x.col(2), 0.98));
  }
  // A cell is a fifth of the pile's height, so that is the discretisation.
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(spread[1][axis], spread[0][axis], 0.12 * spread[0][axis]) << axis;
}

TEST(StabilityLimit, IsWhereItIsPredicted) {
  // With kappa from .8 on blocks blow up; at .7 they must not.
  const auto grows = [](double courant) {
    MpmPlan plan;
    plan.gravity = Vec3::Zero();
    plan.settings.cell = CELL;
    plan.settings.precision = Precision::f64;
    plan.settings.courant = courant;
    plan.settings.max_deformation = 1e9;
    Material material = elastic(1e5);
    plan.bodies.push_back(box_of_matter(Vec3(0, 0, 0), Vec3(0.4, 0.4, 0.4), CELL, 8, material));
    plan.bodies[0].velocity_field = [](const Vec3& x) {
      return Vec3(1e-3 * std::sin(40 * x.x()), 1e-3 * std::cos(55 * x.y()), 1e-3 * std::sin(70 * x.z()));
    };
    const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
    const double before = simulation->totals().kinetic_energy;
    for (int step = 0; step < 600; ++step) {
      if (!simulation->step(1e9).ok())
        return true;
    }
    const Totals after = simulation->totals();
    return after.kinetic_energy + after.elastic_energy > 2.0 * before;
  };
  EXPECT_FALSE(grows(0.4));
  EXPECT_FALSE(grows(0.7));
  EXPECT_TRUE(grows(1.3));
}

} // namespace
} // namespace wry::mpm
