#include <cmath>

#include <gtest/gtest.h>

#include "tests/extreme_table.h"
#include "tests/fem/contact_scene_support.h"

namespace wry::fem {
namespace {

using namespace test;

/// A box that flies down onto a fixed slab of some thickness.
FemPlan box_onto_floor(double speed, double floor_thickness, double box_height = 0.2) {
  FemPlan plan;
  plan.bodies.push_back(
      box_body("floor", Vec3(-0.3, -floor_thickness, -0.3), Vec3(0.8, floor_thickness, 0.8), {4, 1, 4}, 1e8));
  plan.bodies.push_back(box_body("box", Vec3(0, 0.3, 0), Vec3(0.2, box_height, 0.2), {2, 1, 2}, 1e6));
  plan.bodies[1].initial_velocity = Vec3(0, -speed, 0);
  fix_body(plan, 0);
  plan.contact = ContactOptions{};
  plan.settings.max_time_step = 1.0 / 24.0;
  return plan;
}

class FastBox : public ::testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(FastBox, NeverPassesAThinFloor) {
  const auto [speed, thickness] = GetParam();
  const Outcome outcome = run_and_check(box_onto_floor(speed, thickness), 2.0 / 24.0,
                                        fmt::format("box at {:g} m/s onto a floor of {:g} m", speed, thickness));
  EXPECT_EQ(outcome.intersection, "");
  EXPECT_EQ(outcome.error, "");
  EXPECT_GT(outcome.contacts, 0);
  EXPECT_GT(outcome.least_gap, 0.0);
}

INSTANTIATE_TEST_SUITE_P(Extremes, FastBox,
                         ::testing::Combine(::testing::Values(50.0, 100.0, 150.0, 1000.0),
                                            ::testing::Values(0.05, 0.001)));

TEST(ContactExtremes, SheetsAtAnySpeedDoNotTunnel) {
  for (const double speed : {10.0, 100.0, 1000.0}) {
    const Outcome outcome =
        run_and_check(box_onto_floor(speed, 0.002, 0.002), 2.0 / 24.0, fmt::format("sheet at {:g} m/s", speed));
    EXPECT_EQ(outcome.intersection, "") << speed;
    EXPECT_EQ(outcome.error, "") << speed;
    EXPECT_GT(outcome.contacts, 0) << speed;
  }
}

/// A small box at rest a gap above a fixed slab.
FemPlan box_over_slab(double gap) {
  FemPlan plan = box_onto_floor(0.0, 0.05, 0.1);
  std::shared_ptr<geometry::TetMesh> mesh = std::make_shared<geometry::TetMesh>(*plan.bodies[1].mesh);
  mesh->vertices.col(1).array() += gap - 0.3;
  // The lowest vertices stand exactly at the gap, whatever the subtraction rounds to.
  for (Eigen::Index i = 0; i < mesh->vertices.rows(); ++i) {
    if (mesh->vertices(i, 1) < 0.01)
      mesh->vertices(i, 1) = gap;
  }
  plan.bodies[1].mesh = mesh;
  plan.settings.max_time_step = 0.01;
  return plan;
}

TEST(ContactExtremes, TinyGapsAtTheStartAreKeptOrRefusedByName) {
  for (const double gap : {1e-4, 1e-8}) {
    const Outcome outcome = run_and_check(box_over_slab(gap), 0.05, fmt::format("a gap of {:g} m at the start", gap));
    EXPECT_EQ(outcome.intersection, "") << gap;
    EXPECT_EQ(outcome.error, "") << gap;
  }
  // The barrier of such a gap is so stiff that conjugate gradients alone may give up; a direct solver does not.
  const Outcome tiny = run_and_check(box_over_slab(1e-12), 0.05, "a gap of 1e-12 m at the start");
  EXPECT_EQ(tiny.intersection, "");
  EXPECT_TRUE(tiny.error.empty() || tiny.error.find("no step from t") != std::string::npos) << tiny.error;
  for (const double gap : {1e-16, 0.0, -1e-3}) {
    const Outcome outcome = run_and_check(box_over_slab(gap), 0.05, fmt::format("a gap of {:g} m at the start", gap));
    EXPECT_NE(outcome.error.find("at the start"), std::string::npos) << gap << outcome.error;
    EXPECT_EQ(outcome.steps, 0);
  }
}

TEST(ContactExtremes, HeavyRestsOnLight) {
  for (const double ratio : {1e3, 1e6}) {
    FemPlan plan;
    plan.bodies.push_back(box_body("light", Vec3(0, 1e-3, 0), Vec3(0.2, 0.2, 0.2), {1, 1, 1}, 1e9));
    plan.bodies.push_back(box_body("heavy", Vec3(0, 0.202, 0), Vec3(0.2, 0.2, 0.2), {1, 1, 1}, 1e9));
    plan.bodies[0].material.density = 1000.0;
    plan.bodies[1].material.density = 1000.0 * ratio;
    plan.planes.push_back({"ground", Vec3::Zero(), Vec3::UnitY(), 0.5});
    plan.contact = ContactOptions{};
    const Outcome outcome = run_and_check(plan, 0.05, fmt::format("{:g} times heavier on light", ratio));
    EXPECT_EQ(outcome.intersection, "") << ratio;
    EXPECT_EQ(outcome.error, "") << ratio;
    EXPECT_GT(outcome.contacts, 0) << ratio;
  }
}

TEST(ContactExtremes, AnyDhatWorksEvenWhenItIsLargerThanTheGapOrTheEdge) {
  for (const double share : {1.0, 1e-2, 1e-4, 1e-6}) {
    FemPlan plan = box_over_slab(0.004);
    plan.settings.contact_distance = 0.2 * share;
    const Outcome outcome = run_and_check(plan, 0.1, fmt::format("d-hat {:g} of the size", share));
    EXPECT_EQ(outcome.intersection, "") << share;
    EXPECT_EQ(outcome.error, "") << share;
  }
}

TEST(ContactExtremes, FiveNewtonIterationsMakeShorterStepsButNoIntersection) {
  FemPlan plan = box_onto_floor(3.0, 0.05);
  plan.settings.max_newton_iterations = 5;
  plan.settings.max_time_step = 0.01;
  plan.settings.newton_tolerance = 1e-3;
  plan.settings.min_time_step = 1e-6;
  const Outcome outcome = run_and_check(plan, 0.12, "five Newton iterations at most");
  EXPECT_EQ(outcome.intersection, "");
  EXPECT_TRUE(outcome.error.empty() || outcome.error.find("last good state") != std::string::npos) << outcome.error;
}

scene::Collider mesh_collider(const std::string& name, const Points& vertices, const Triangles& triangles) {
  geometry::SurfaceMesh mesh;
  mesh.vertices = vertices;
  mesh.triangles = triangles;
  scene::Collider collider;
  collider.name = name;
  collider.shape = scene::MeshObstacle{std::make_shared<geometry::SurfaceMesh>(mesh), false, 0.0};
  collider.friction = 0.0;
  return collider;
}

TEST(ContactExtremes, ABallOfTetsRestsOnPinsOfSinglePointsAndSegments) {
  for (const bool segments : {false, true}) {
    FemPlan plan;
    plan.bodies.push_back(box_body("box", Vec3(0, 0.01, 0), Vec3(0.2, 0.1, 0.2), {2, 1, 2}, 1e6));
    Points vertices(18, 3);
    Triangles triangles(segments ? 9 : 0, 3);
    for (int i = 0; i < 9; ++i) {
      vertices.row(2 * i) << 0.03 + 0.07 * (i % 3), 0.0, 0.03 + 0.07 * (i / 3);
      vertices.row(2 * i + 1) << 0.03 + 0.07 * (i % 3), -0.1, 0.035 + 0.07 * (i / 3);
      if (segments)
        triangles.row(i) << 2 * i, 2 * i, 2 * i + 1;
    }
    plan.obstacles.push_back(mesh_collider("pins", vertices, triangles));
    const std::unique_ptr<FemSimulation> simulation = simulate(plan);
    ASSERT_NE(simulation, nullptr);
    const int steps = run_until(*simulation, 0.3);
    wry::test::note_extreme("contact", segments ? "a box on pins of segments" : "a box on pins of points",
                            {"holds", steps, 0, 0, 0.0, ""});
    EXPECT_GT(positions_of(*simulation).col(1).mean(), 0.04) << segments;
    EXPECT_LT(positions_of(*simulation).col(1).mean(), 0.0625) << segments;
  }
}

TEST(ContactExtremes, AMeshThatJumpsThroughABodyPushesItOrStopsTheRun) {
  FemPlan plan;
  plan.gravity.setZero();
  plan.bodies.push_back(box_body("box", Vec3(0, 0, 0), Vec3(0.1, 0.1, 0.1), {2, 2, 2}, 1e5));
  scene::Collider blade;
  blade.name = "blade";
  blade.shape = scene::BoxObstacle{Vec3(-0.05, 0.05, 0.05), Mat3::Identity(), Vec3(0.02, 0.3, 0.3)};
  blade.motion = *scene::Motion::along_keys(
      {{{0.0, Vec3::Zero(), Vec3::UnitY(), 0.0}, {0.01, Vec3(0.6, 0, 0), Vec3::UnitY(), 0.0}}, Vec3::Zero()});
  plan.obstacles.push_back(blade);
  const Result<std::unique_ptr<FemSimulation>> made = FemSimulation::create(plan, 1, native_isa());
  ASSERT_TRUE(made);
  FemSimulation& simulation = **made;
  wry::test::ExtremeRow row;
  while (simulation.time() < 0.02) {
    const Result<StepStats> stats = simulation.step(0.02);
    row.steps += stats ? 1 : 0;
    row.iterations += stats ? stats->newton_iterations : 0;
    row.cuts += stats ? stats->cuts : 0;
    row.worst_residual = std::max(row.worst_residual, stats ? stats->residual : 0.0);
    row.outcome = !stats ? "refuses" : row.cuts > 0 ? "shorter steps" : "holds";
    row.said = stats ? "" : stats.error().message;
    if (!stats) {
      EXPECT_NE(stats.error().message.find("last good state is kept"), std::string::npos);
      break;
    }
    const double blade_front = -0.04 + 60.0 * std::min(simulation.time(), 0.01);
    ASSERT_GT(positions_of(simulation).col(0).minCoeff(), blade_front) << simulation.time();
  }
  wry::test::note_extreme("contact", "a mesh that jumps through a body", row);
}

scene::Collider moving_plate(const std::string& name, double height, double way) {
  scene::Collider plate;
  plate.name = name;
  plate.shape = scene::BoxObstacle{Vec3(0.05, height, 0.05), Mat3::Identity(), Vec3(0.4, 0.02, 0.4)};
  plate.friction = 0.0;
  plate.motion = *scene::Motion::along_keys({{{0.0, Vec3::Zero(), Vec3::UnitY(), 0.0},
                                              {1.0, Vec3(0, way, 0), Vec3::UnitY(), 0.0},
                                              {1.2, Vec3(0, 1.1 * way, 0), Vec3::UnitY(), 0.0}},
                                             Vec3::Zero()});
  return plate;
}

TEST(ContactExtremes, ABoxIsSqueezedToAHundredthAndTheRunStopsBeforeThePlatesCross) {
  FemPlan plan;
  plan.gravity.setZero();
  plan.bodies.push_back(box_body("box", Vec3(0, 0, 0), Vec3(0.1, 0.1, 0.1), {2, 2, 2}, 1e5));
  // Faces at -0.002 and 0.102 that come to 0.001 of each other, and would then pass.
  plan.obstacles.push_back(moving_plate("lower", -0.012, 0.0515));
  plan.obstacles.push_back(moving_plate("upper", 0.112, -0.0515));
  plan.settings.max_time_step = 0.02;
  plan.settings.contact_distance = 2e-4;
  plan.settings.min_time_step = 1e-5;
  const Outcome outcome = run_and_check(plan, 1.2, "squeezed to a hundredth, then the plates cross");
  EXPECT_EQ(outcome.intersection, "");
  EXPECT_GT(outcome.reached, 0.999);
  EXPECT_LT(outcome.reached, 1.1);
  EXPECT_GT(outcome.least_gap, 0.0);
  EXPECT_NE(outcome.error.find("last good state is kept"), std::string::npos) << outcome.error;
  EXPECT_NE(outcome.error.find("er'"), std::string::npos) << outcome.error; // 'lower' or 'upper'
}

TEST(ContactExtremes, ADriveThatLeadsThroughAnObstacleStopsTheRunAndSaysSo) {
  FemPlan plan;
  plan.gravity.setZero();
  plan.bodies.push_back(box_body("box", Vec3(0, 0, 0), Vec3(0.1, 0.1, 0.1), {2, 2, 2}, 1e5));
  scene::Collider wall;
  wall.name = "wall";
  wall.shape = scene::BoxObstacle{Vec3(0.2, 0.05, 0.05), Mat3::Identity(), Vec3(0.02, 0.3, 0.3)};
  plan.obstacles.push_back(wall);
  DrivenNodes drive;
  drive.name = "push";
  drive.nodes = vertices_at(*plan.bodies[0].mesh, 0, 0.1); // the side that meets the wall
  drive.motion = *scene::Motion::along_keys(
      {{{0.0, Vec3::Zero(), Vec3::UnitY(), 0.0}, {0.1, Vec3(0.3, 0, 0), Vec3::UnitY(), 0.0}}, Vec3::Zero()});
  plan.driven.push_back(drive);
  plan.settings.min_time_step = 1e-4;
  const Outcome outcome = run_and_check(plan, 0.1, "a drive that leads through an obstacle");
  EXPECT_NE(outcome.error.find("a drive leads through an obstacle"), std::string::npos) << outcome.error;
  EXPECT_NE(outcome.error.find("last good state is kept"), std::string::npos) << outcome.error;
  // 0.09 m of way at 3 m/s before the wall.
  EXPECT_GT(outcome.reached, 0.028);
  EXPECT_LT(outcome.reached, 0.0301);
}

} // namespace
} // namespace wry::fem
