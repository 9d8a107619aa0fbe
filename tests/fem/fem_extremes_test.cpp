#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/fem/solid_support.h"

namespace wry::fem {
namespace {

using namespace test;

FemPlan hanging_beam(ElasticModel model, double youngs_modulus, double poisson_ratio) {
  const std::shared_ptr<const geometry::TetMesh> mesh = box_mesh(Vec3::Zero(), Vec3(1.0, 0.2, 0.2), 8, 2, 2);
  FemPlan plan = plan_of(make_body(mesh, model, youngs_modulus, poisson_ratio));
  plan.gravity = Vec3(0, -9.81, 0);
  plan.fixed.push_back({"clamp", 0, vertices_at(*mesh, 0, 0.0), true, true, {}});
  return plan;
}

TEST(FemExtremes, EveryDecadeOfStiffnessConverges) {
  for (const ElasticModel model : {ElasticModel::neo_hookean, ElasticModel::micropolar}) {
    for (int decade = 2; decade <= 12; ++decade) {
      const double youngs_modulus = std::pow(10.0, decade);
      const std::unique_ptr<FemSimulation> simulation = simulate(hanging_beam(model, youngs_modulus, 0.3));
      for (int i = 0; i < 5; ++i) {
        const Result<StepStats> stats = simulation->step(1.0);
        ASSERT_TRUE(stats) << "1e" << decade << ": " << stats.error().message;
        EXPECT_TRUE(std::isfinite(stats->elastic_energy));
      }
      EXPECT_TRUE(positions_of(*simulation).allFinite());
    }
  }
}

TEST(FemExtremes, NearlyIncompressibleConverges) {
  for (const double poisson_ratio : {0.45, 0.49, 0.499, 0.4999}) {
    const std::unique_ptr<FemSimulation> simulation =
        simulate(hanging_beam(ElasticModel::neo_hookean, 1e5, poisson_ratio));
    EXPECT_GT(run_until(*simulation, 0.1), 0) << poisson_ratio;
  }
}

TEST(FemExtremes, ARandomHeapOfMicropolarNodesRecovers) {
  FemPlan plan =
      plan_of(make_body(box_mesh(Vec3::Zero(), Vec3(0.2, 0.2, 0.2), 3, 3, 3), ElasticModel::micropolar, 1e4, 0.3));
  plan.bodies[0].material.rotary_inertia = 0.01;
  plan.settings.max_newton_iterations = 200;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  StateArchive archive = simulation->archive();
  std::mt19937 generator(7);
  for (NamedArray& array : archive) {
    for (std::size_t i = 0; array.name == "fem/body0/positions" && i < array.values.size(); ++i)
      array.values[i] = 0.2 * static_cast<double>(generator()) / 4294967296.0;
  }
  ASSERT_TRUE(simulation->restore(archive));
  double first = 0.0;
  double last = 0.0;
  while (simulation->time() < 3.0) {
    const Result<StepStats> stats = simulation->step(3.0);
    ASSERT_TRUE(stats) << stats.error().message;
    first = first == 0.0 ? stats->elastic_energy : first;
    last = stats->elastic_energy;
  }
  EXPECT_LT(last, 0.05 * first);
}

TEST(FemExtremes, AnInvertedLogBarrierBodyIsRefusedWithNumbers) {
  const std::unique_ptr<FemSimulation> simulation = simulate(hanging_beam(ElasticModel::neo_hookean, 1e5, 0.3));
  StateArchive archive = simulation->archive();
  for (NamedArray& array : archive) {
    if (array.name == "fem/body0/positions")
      std::swap(array.values[60], array.values[81]);
  }
  ASSERT_TRUE(simulation->restore(archive));
  const std::uint64_t before = hash_of(simulation->archive());
  const Result<StepStats> stats = simulation->step(1.0);
  ASSERT_FALSE(stats);
  EXPECT_EQ(stats.error().code, ErrorCode::solver);
  EXPECT_NE(stats.error().message.find("not finite"), std::string::npos) << stats.error().message;
  // The state is that of the last accepted step; only the step control remembers.
  StateArchive after = simulation->archive();
  for (NamedArray& array : after) {
    if (array.name == "fem/step_control")
      array.values = archive[0].name == "fem/step_control" ? archive[0].values : std::vector<double>{0.01, 0.0};
  }
  EXPECT_EQ(hash_of(after), before);
}

TEST(FemExtremes, WhatBreaksPhysicsIsRefusedAtOnce) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](const FemPlan& plan) {
    const Result<std::unique_ptr<FemSimulation>> made = FemSimulation::create(plan, 1, native_isa());
    return !made && made.error().code == ErrorCode::bad_input;
  };
  const FemPlan good = hanging_beam(ElasticModel::micropolar, 1e5, 0.3);
  EXPECT_FALSE(refused(good));
  for (const double ratio : {0.5, 0.51, -1.0, nan}) {
    FemPlan plan = good;
    plan.bodies[0].material.poisson_ratio = ratio;
    EXPECT_TRUE(refused(plan)) << ratio;
  }
  FemPlan singular = good;
  singular.bodies[0].material.couple_modulus_ratio = 0.0;
  EXPECT_TRUE(refused(singular));
  singular.bodies[0].material.rotary_inertia = 0.01;
  EXPECT_FALSE(refused(singular));
  FemPlan gravity = good;
  gravity.gravity[1] = nan;
  EXPECT_TRUE(refused(gravity));
  FemPlan flat = good;
  std::shared_ptr<geometry::TetMesh> mesh = std::make_shared<geometry::TetMesh>(*good.bodies[0].mesh);
  mesh->tets(5, 1) = mesh->tets(5, 2);
  flat.bodies[0].mesh = mesh;
  EXPECT_TRUE(refused(flat));
  std::shared_ptr<geometry::TetMesh> hole = std::make_shared<geometry::TetMesh>(*good.bodies[0].mesh);
  hole->vertices(3, 1) = nan;
  flat.bodies[0].mesh = hole;
  EXPECT_TRUE(refused(flat));
}

TEST(FemExtremes, ExtentsOfAnySizeFallAlike) {
  for (const double size : {1e-4, 1.0, 1e4}) {
    FemPlan plan =
        plan_of(make_body(box_mesh(Vec3::Zero(), Vec3::Constant(size), 2, 2, 2), ElasticModel::neo_hookean, 1e5, 0.3));
    plan.gravity = Vec3(0, -9.81, 0);
    const std::unique_ptr<FemSimulation> simulation = simulate(plan);
    run_until(*simulation, 0.1);
    // Backward Euler falls g t (t + dt) / 2, with dt at most 10 ms; steps may be cut.
    const double fall = size / 2 - positions_of(*simulation).col(1).mean();
    EXPECT_GT(fall, 9.81 * 0.1 * 0.1 / 2 - 1e-4) << size;
    EXPECT_LT(fall, 9.81 * 0.1 * 0.11 / 2 + 1e-4) << size;
  }
}

/// A straight strut between two clamps that come nearer, pushed aside by next to nothing: the straight state is a
/// saddle of the incremental potential, along which projected Newton directions only creep.
TEST(FemExtremes, AStrutLeavesTheRidgeItIsPressedOnto) {
  for (const ElasticModel model : {ElasticModel::neo_hookean, ElasticModel::micropolar}) {
    const std::shared_ptr<const geometry::TetMesh> mesh = box_mesh(Vec3::Zero(), Vec3(0.02, 1.0, 0.02), 1, 40, 1);
    FemPlan plan = plan_of(make_body(mesh, model, 2e5, 0.3));
    plan.gravity = Vec3(1e-6, 0, 0);
    plan.fixed.push_back({"foot", 0, vertices_at(*mesh, 1, 0.0), true, true, {}});
    DrivenNodes drive;
    drive.name = "press";
    drive.nodes = vertices_at(*mesh, 1, 1.0);
    drive.motion =
        scene::Motion::along_keys(
            {{{0.0, Vec3::Zero(), Vec3::UnitX(), 0.0}, {5.0, Vec3(0, -0.05, 0), Vec3::UnitX(), 0.0}}, Vec3::Zero()})
            .value();
    plan.driven.push_back(drive);
    plan.settings.max_time_step = 2.0;
    const std::unique_ptr<FemSimulation> simulation = simulate(plan);
    const Result<StepStats> stats = simulation->step(2.0);
    ASSERT_TRUE(stats) << stats.error().message;
    EXPECT_EQ(stats->cuts, 0);
    EXPECT_LT(stats->newton_iterations, 30);
    EXPECT_GT(positions_of(*simulation).col(0).maxCoeff(), 0.05) << "it is still straight";
  }
}

} // namespace
} // namespace wry::fem
