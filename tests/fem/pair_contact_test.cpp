#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/fem/contact_scene_support.h"

namespace wry::fem {
namespace {

using namespace test;

FemPlan two_boxes(double speed) {
  FemPlan plan;
  plan.gravity.setZero();
  plan.bodies.push_back(box_body("left", Vec3(0, 0, 0), Vec3(0.2, 0.2, 0.2), {2, 2, 2}));
  plan.bodies.push_back(box_body("right", Vec3(0.25, 0.05, 0.03), Vec3(0.2, 0.2, 0.2), {3, 3, 3}));
  plan.bodies[0].initial_velocity = Vec3(speed, 0, 0);
  plan.contact = ContactOptions{};
  return plan;
}

TEST(PairContact, BoxesThatCollideKeepTheirMomentumAndNeverIntersect) {
  for (const double speed : {1.0, 30.0, 1000.0}) {
    const FemPlan plan = two_boxes(speed);
    const std::unique_ptr<FemSimulation> simulation = simulate(plan);
    ASSERT_NE(simulation, nullptr);
    const Vec3 before = momentum_of(plan, *simulation);
    int contacts = 0;
    const double end = 0.15 / speed;
    while (simulation->time() < end) {
      const Result<StepStats> stats = simulation->step(end);
      ASSERT_TRUE(stats) << speed << ": " << stats.error().message;
      contacts += stats->contacts;
      ASSERT_EQ(find_intersection(plan, *simulation), "") << speed;
    }
    EXPECT_GT(contacts, 0) << speed;
    EXPECT_NEAR((momentum_of(plan, *simulation) - before).norm(), 0.0, 1e-5 * before.norm()) << speed;
    EXPECT_GT(velocity_of(plan, *simulation, 1).x(), 0.1 * speed) << speed;
  }
}

TEST(PairContact, WithoutContactTheBoxesPassThroughEachOther) {
  FemPlan plan = two_boxes(1.0);
  plan.contact.reset();
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  run_until(*simulation, 0.2);
  EXPECT_NE(find_intersection(plan, *simulation), "");
}

TEST(PairContact, TheFirstStepIsNotChargedWithTheSearchOfSettingUp) {
  FemPlan plan = two_boxes(1.0);
  plan.bodies[0] = box_body("left", Vec3(0, 0, 0), Vec3(0.2, 0.2, 0.2), {16, 16, 16});
  plan.contact->within_bodies = true;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  ASSERT_NE(simulation, nullptr);
  for (int step = 1; step <= 2; ++step) {
    const Result<StepStats> stats = simulation->step(0.001 * step);
    ASSERT_TRUE(stats);
    EXPECT_GT(stats->contact_search_ms, 0.0);
    EXPECT_LE(stats->solve_ms + stats->contact_search_ms + stats->safe_step_ms, stats->total_ms) << step;
  }
}

TEST(PairContact, ThreadsAndAFreshObjectDoNotChangeABit) {
  const FemPlan plan = two_boxes(10.0);
  const std::unique_ptr<FemSimulation> one = simulate(plan, 1);
  const std::unique_ptr<FemSimulation> three = simulate(plan, 3);
  run_until(*one, 0.01);
  run_until(*three, 0.01);
  EXPECT_EQ(hash_of(one->archive()), hash_of(three->archive()));
  const std::unique_ptr<FemSimulation> fresh = simulate(plan, 2);
  ASSERT_TRUE(fresh->restore(one->archive()));
  run_until(*one, 0.02);
  run_until(*fresh, 0.02);
  EXPECT_EQ(hash_of(one->archive()), hash_of(fresh->archive()));
}

/// A block on a fixed slab under a gravity turned by atan(0.5).
FemPlan block_on_slope(Friction friction, double speed, double tangent = 0.5) {
  FemPlan plan;
  plan.bodies.push_back(box_body("slab", Vec3(-0.3, -0.05, -0.2), Vec3(1.4, 0.05, 0.6), {5, 1, 3}, 1e7));
  plan.bodies.push_back(box_body("block", Vec3(0, 9e-4, 0), Vec3(0.2, 0.1, 0.2), {2, 1, 2}, 1e6));
  plan.bodies[1].initial_velocity = Vec3(speed, 0, 0);
  const double angle = std::atan(tangent);
  plan.gravity = 9.81 * Vec3(std::sin(angle), -std::cos(angle), 0);
  fix_body(plan, 0);
  plan.contact = ContactOptions{true, false, friction, {}};
  plan.settings.contact_distance = 1e-3;
  return plan;
}

double speed_gained(const Friction& friction, double speed, double friction_velocity = 1e-3) {
  FemPlan plan = block_on_slope(friction, speed);
  plan.settings.friction_velocity = friction_velocity;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  run_until(*simulation, 0.3);
  const double before = velocity_of(plan, *simulation, 1).x();
  run_until(*simulation, 0.6);
  return (velocity_of(plan, *simulation, 1).x() - before) / 0.3;
}

TEST(PairContact, ABlockOnASlabOfATangentOfAHalfSlidesAndSticksByCoulomb) {
  const double cosine = 1.0 / std::sqrt(1.25);
  const auto expected = [&](double mu) { return 9.81 * cosine * (0.5 - mu); };
  EXPECT_NEAR(speed_gained({0.3, 0.3}, 0.0), expected(0.3), 0.02 * expected(0.3));
  EXPECT_NEAR(speed_gained({0.49, 0.49}, 0.0), expected(0.49), 0.01);
  EXPECT_NEAR(speed_gained({0.5, 0.5}, 0.0), 0.0, 2e-3);
  EXPECT_NEAR(speed_gained({1.0, 1.0}, 0.0), 0.0, 1e-3);
  EXPECT_NEAR(speed_gained({10.0, 10.0}, 0.0), 0.0, 1e-3);
}

TEST(PairContact, WhatRestsHoldsByTheFrictionAtRestAndWhatSlidesByTheSlidingOne) {
  const double cosine = 1.0 / std::sqrt(1.25);
  // Before it lands it gains 4 cm/s, which is to count as rest here.
  EXPECT_NEAR(speed_gained({0.6, 0.3}, 0.0, 0.1), 0.0, 2e-3);
  EXPECT_NEAR(speed_gained({0.6, 0.3}, 0.3, 0.1), 9.81 * cosine * 0.2, 0.05);
}

TEST(PairContact, ASlidingBlockStopsAfterItsStoppingDistance) {
  // v^2 / (2 mu g) on level ground.
  FemPlan plan = block_on_slope({0.4, 0.4}, 1.5, 0.0);
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  const double start = positions_of(*simulation, 1).col(0).mean();
  run_until(*simulation, 0.6);
  EXPECT_NEAR(positions_of(*simulation, 1).col(0).mean() - start, 1.5 * 1.5 / (2 * 0.4 * 9.81), 0.02);
  EXPECT_LT(velocity_of(plan, *simulation, 1).norm(), 2e-3);
}

TEST(PairContact, FrictionFollowsTheNormalForcesThroughAnImpact) {
  // While it slides, a block loses mu times the speed that the ground gives it upwards, however hard it lands.
  constexpr double MU = 0.3;
  FemPlan plan = block_on_slope({MU, MU}, 3.0, 0.0);
  plan.bodies[1].initial_velocity.y() = -1.5;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  const Vec3 before = velocity_of(plan, *simulation, 1);
  run_until(*simulation, 0.1);
  const Vec3 gained = velocity_of(plan, *simulation, 1) - before;
  const double given = gained.y() + 9.81 * 0.1;
  EXPECT_GT(given, 1.5);
  EXPECT_NEAR(-gained.x() / given, MU, 0.01 * MU);
}

TEST(PairContact, AStackOfBoxesComesToRest) {
  FemPlan plan;
  for (int i = 0; i < 3; ++i)
    plan.bodies.push_back(
        box_body(fmt::format("box{}", i), Vec3(0.01 * i, 0.1005 * i, 0), Vec3(0.1, 0.1, 0.1), {2, 2, 2}, 1e6));
  plan.planes.push_back({"ground", Vec3::Zero(), Vec3::UnitY(), 0.5});
  plan.contact = ContactOptions{true, true, {0.5, 0.5}, {}};
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  run_until(*simulation, 0.8);
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(velocity_of(plan, *simulation, i).norm(), 1e-3) << i;
    EXPECT_NEAR(positions_of(*simulation, i).col(1).mean(), 0.05 + 0.1 * i, 2e-3) << i;
  }
  EXPECT_EQ(find_intersection(plan, *simulation), "");
}

/// A hairpin on its side, soft, whose upper leg sinks onto the lower one.
FemPlan hairpin(bool within) {
  std::shared_ptr<geometry::TetMesh> mesh =
      std::make_shared<geometry::TetMesh>(*box_mesh(Vec3(0, 0, 0), Vec3(1.1, 0.02, 0.1), 22, 1, 1));
  for (Eigen::Index i = 0; i < mesh->vertices.rows(); ++i) {
    const double s = mesh->vertices(i, 0);
    const double offset = mesh->vertices(i, 1);
    constexpr double RADIUS = 0.03;
    const double turn = (s - 0.5) / (1.1 - 1.0) * M_PI; // the bend is 0.1 long
    if (s <= 0.5)
      mesh->vertices.row(i).head<2>() << -s, offset;
    else if (s < 0.6)
      mesh->vertices.row(i).head<2>() << -0.5 - (RADIUS - offset) * std::sin(turn),
          RADIUS - (RADIUS - offset) * std::cos(turn);
    else
      mesh->vertices.row(i).head<2>() << -0.5 + (s - 0.6), 2 * RADIUS - offset;
  }
  for (Eigen::Index t = 0; t < mesh->tets.rows(); ++t) {
    const Vec3 a = mesh->vertices.row(mesh->tets(t, 1)) - mesh->vertices.row(mesh->tets(t, 0));
    const Vec3 b = mesh->vertices.row(mesh->tets(t, 2)) - mesh->vertices.row(mesh->tets(t, 0));
    const Vec3 c = mesh->vertices.row(mesh->tets(t, 3)) - mesh->vertices.row(mesh->tets(t, 0));
    if (a.cross(b).dot(c) < 0.0)
      std::swap(mesh->tets(t, 2), mesh->tets(t, 3));
  }
  FemPlan plan;
  plan.bodies.push_back(make_body(mesh, ElasticModel::neo_hookean, 5e3, 0.3));
  FixedNodes fixed;
  for (Eigen::Index i = 0; i < mesh->vertices.rows(); ++i) {
    if (mesh->vertices(i, 1) < 1e-9)
      fixed.nodes.push_back(static_cast<std::int32_t>(i));
  }
  plan.fixed.push_back(fixed);
  plan.contact = ContactOptions{true, within, {0.2, 0.2}, {}};
  return plan;
}

TEST(PairContact, ABodyThatFoldsRestsOnItself) {
  const Outcome with = run_and_check(hairpin(true), 0.2);
  EXPECT_EQ(with.error, "");
  EXPECT_EQ(with.intersection, "");
  EXPECT_GT(with.contacts, 5);
  const Outcome without = run_and_check(hairpin(false), 0.2);
  EXPECT_NE(without.intersection, "") << "the scene does not fold";
}

TEST(PairContact, AMovingSphereCarriesABoxAndNeverEntersIt) {
  FemPlan plan;
  plan.gravity.setZero();
  plan.bodies.push_back(box_body("box", Vec3(0, 0, 0), Vec3(0.2, 0.2, 0.2), {3, 3, 3}));
  scene::Collider ball;
  ball.name = "ball";
  ball.shape = scene::SphereObstacle{Vec3(-0.15, 0.1, 0.1), 0.1};
  ball.motion = *scene::Motion::along_keys(
      {{{0.0, Vec3::Zero(), Vec3::UnitY(), 0.0}, {0.5, Vec3(0.5, 0, 0), Vec3::UnitY(), 0.0}}, Vec3::Zero()});
  plan.obstacles.push_back(ball);
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  ASSERT_NE(simulation, nullptr);
  while (simulation->time() < 0.5) {
    const Result<StepStats> stats = simulation->step(0.5);
    ASSERT_TRUE(stats) << stats.error().message;
    const Vec3 centre(-0.15 + simulation->time(), 0.1, 0.1);
    const double nearest = (positions_of(*simulation).rowwise() - centre.transpose()).rowwise().norm().minCoeff();
    ASSERT_GT(nearest, 0.095);
  }
  EXPECT_GT(positions_of(*simulation).col(0).minCoeff(), 0.38);
}

TEST(PairContact, AStageBeginsWhereObstaclesAreAtTheStartOfTheStep) {
  // A plate sinks away from under a box that falls as fast, 2 mm above it: they never feel each other. In a step of
  // 10 ms it moves 10 mm: were it placed at any other time than the start of the step, it would stand in the box.
  for (const Integrator integrator : {Integrator::backward_euler, Integrator::bdf2, Integrator::sdirk2}) {
    FemPlan plan;
    plan.gravity.setZero();
    plan.settings.integrator = integrator;
    plan.settings.max_time_step = 0.01;
    plan.settings.contact_distance = 1e-3;
    plan.bodies.push_back(box_body("box", Vec3(0, 0, 0), Vec3(0.1, 0.1, 0.1), {2, 2, 2}));
    plan.bodies[0].initial_velocity = Vec3(0, -1, 0);
    scene::Collider plate;
    plate.name = "plate";
    plate.shape = scene::BoxObstacle{Vec3(0.05, -0.022, 0.05), Mat3::Identity(), Vec3(0.3, 0.04, 0.3)};
    plate.motion = *scene::Motion::along_keys(
        {{{0.0, Vec3::Zero(), Vec3::UnitY(), 0.0}, {0.2, Vec3(0, -0.2, 0), Vec3::UnitY(), 0.0}}, Vec3::Zero()});
    plan.obstacles.push_back(plate);
    const std::unique_ptr<FemSimulation> simulation = simulate(plan);
    ASSERT_NE(simulation, nullptr);
    for (int step = 0; step < 20; ++step) {
      const Result<StepStats> stats = simulation->step(0.2);
      ASSERT_TRUE(stats) << stats.error().message;
      EXPECT_EQ(stats->cuts, 0);
      EXPECT_EQ(stats->contacts, 0);
    }
    EXPECT_NEAR(simulation->time(), 0.2, 1e-12);
    EXPECT_LT((velocity_of(plan, *simulation, 0) - Vec3(0, -1, 0)).norm(), 1e-5);
  }
}

TEST(PairContact, PlatesThatCrossStopTheRunAndKeepTheLastGoodState) {
  FemPlan plan;
  plan.gravity.setZero();
  plan.bodies.push_back(box_body("box", Vec3(0, 0, 0), Vec3(0.1, 0.1, 0.1), {2, 2, 2}));
  plan.settings.min_time_step = 1e-4;
  for (const double side : {-1.0, 1.0}) {
    scene::Collider plate;
    plate.name = side < 0 ? "lower" : "upper";
    plate.shape = scene::BoxObstacle{Vec3(0.05, 0.05 + 0.08 * side, 0.05), Mat3::Identity(), Vec3(0.3, 0.04, 0.3)};
    plate.motion = *scene::Motion::along_keys(
        {{{0.0, Vec3::Zero(), Vec3::UnitY(), 0.0}, {0.2, Vec3(0, -0.1 * side, 0), Vec3::UnitY(), 0.0}}, Vec3::Zero()});
    plan.obstacles.push_back(plate);
  }
  const Outcome outcome = run_and_check(plan, 0.2);
  EXPECT_NE(outcome.error.find("last good state is kept"), std::string::npos) << outcome.error;
  EXPECT_NE(outcome.error.find("collider"), std::string::npos) << outcome.error;
  EXPECT_EQ(outcome.intersection, "");
  EXPECT_GT(outcome.reached, 0.08); // 1 % of the height would be left at 0.118 s
  EXPECT_LT(outcome.reached, 0.121);
}

TEST(PairContact, BodiesThatIntersectOrTouchAtTheStartAreRefusedByName) {
  for (const double gap : {-0.05, 0.0, 1e-17}) {
    FemPlan plan = two_boxes(0.0);
    std::shared_ptr<geometry::TetMesh> mesh = std::make_shared<geometry::TetMesh>(*plan.bodies[1].mesh);
    mesh->vertices.col(0).array() += gap - 0.05;
    mesh->vertices.col(0) = mesh->vertices.col(0).cwiseMax(0.2 + gap);
    plan.bodies[1].mesh = mesh;
    const Result<std::unique_ptr<FemSimulation>> simulation = FemSimulation::create(plan, 1, native_isa());
    ASSERT_FALSE(simulation) << gap;
    EXPECT_EQ(simulation.error().code, ErrorCode::bad_input);
    EXPECT_NE(simulation.error().message.find("right"), std::string::npos) << simulation.error().message;
  }
}

} // namespace
} // namespace wry::fem
