#include "sim/fem/rotation_update.h"

#include <cmath>

#include <gtest/gtest.h>

#include "sim/base/rotation.h"
#include "sim/fem/newton.h"
#include "tests/fem/solid_support.h"

namespace wry::fem {
namespace {

using namespace test;

const Vec3 TURNS[] = {Vec3(1e-5, -2e-5, 0), Vec3(0.05, 0.04, -0.06), Vec3(0.06, 0.07, 0.05), Vec3(0.9, -0.4, 1.3)};

TEST(RotationUpdate, CayleysIncrementOfARotationVectorTurnsByItsLength) {
  const Vec4 start = quaternion_exponential(Vec3(0.3, 0.1, -0.7));
  for (const Vec3& turn : TURNS) {
    const Vec4 expected = quaternion_product(quaternion_exponential(turn), start);
    EXPECT_LT((cayley_update(start, cayley_of_rotation_vector(turn)) - expected).norm(), 1e-15);
    EXPECT_LT((rotation_vector_of_cayley(cayley_of_rotation_vector(turn)) - turn).norm(), 1e-15 * (1.0 + turn.norm()));
  }
}

TEST(RotationUpdate, SlopesAndCurvaturesAreConfirmedByDifferences) {
  const Vec3 g(0.7, -1.1, 0.4);
  constexpr double STEP = 1e-5;
  for (const Vec3& turn : TURNS) {
    for (int i = 0; i < 3; ++i) {
      const Vec3 by = STEP * Vec3::Unit(i);
      const Vec3 slope = (cayley_of_rotation_vector(turn + by) - cayley_of_rotation_vector(turn - by)) / (2.0 * STEP);
      EXPECT_LT((cayley_slope(turn).col(i) - slope).norm(), 1e-9);
      const Vec3 curvature = (cayley_slope(turn + by) * g - cayley_slope(turn - by) * g) / (2.0 * STEP);
      EXPECT_LT((cayley_curvature(turn, g).col(i) - curvature).norm(), 1e-9);
    }
  }
}

/// A bar twisted by 25 degrees a step, with rotary inertia; returns Newton iterations of the last step and energies.
StepStats twist(RotationUpdate update, int steps) {
  FemPlan plan =
      plan_of(make_body(box_mesh(Vec3::Zero(), Vec3(0.1, 0.1, 0.4), 2, 2, 4), ElasticModel::micropolar, 1e4, 0.3));
  plan.bodies[0].material.length_scale = 0.05;
  plan.bodies[0].material.curvature = CurvatureModel::isotropic;
  plan.bodies[0].material.rotary_inertia = 1.0;
  plan.bodies[0].material.mass_damping = 1.0;
  plan.settings.rotation_update = update;
  plan.settings.max_time_step = 0.4 / steps;
  plan.settings.newton_tolerance = 1e-11;
  plan.settings.linear_tolerance = 1e-10;
  const geometry::TetMesh& mesh = *plan.bodies[0].mesh;
  plan.fixed.push_back({"foot", 0, vertices_at(mesh, 2, 0.0), true, true, {}});
  DrivenNodes drive;
  drive.nodes = vertices_at(mesh, 2, 0.4);
  drive.motion =
      scene::Motion::along_keys(
          {{{0.0, Vec3::Zero(), Vec3::UnitZ(), 0.0}, {0.4, Vec3::Zero(), Vec3::UnitZ(), 100.0}}, Vec3(0.05, 0.05, 0.0)})
          .value();
  plan.driven.push_back(drive);
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  StepStats last;
  while (simulation->time() < 0.4) {
    const Result<StepStats> stats = simulation->step(0.4);
    EXPECT_TRUE(stats) << stats.error().message;
    if (!stats)
      break;
    EXPECT_LE(stats->newton_iterations, 7) << "Newton's method does not converge quadratically";
    last = *stats;
  }
  return last;
}

TEST(RotationUpdate, NewtonConvergesAsFastAsWithCayley) {
  twist(RotationUpdate::exponential, 4);
  twist(RotationUpdate::cayley, 4);
}

TEST(RotationUpdate, BothUpdatesConvergeToTheSameMotion) {
  // The paper: the error of eq 26 is negligible at usual steps.
  const double exponential = twist(RotationUpdate::exponential, 64).elastic_energy;
  const double cayley = twist(RotationUpdate::cayley, 64).elastic_energy;
  EXPECT_NE(exponential, cayley);
  EXPECT_NEAR(cayley / exponential, 1.0, 1e-3);
}

TEST(RotationUpdate, IsRefusedWithIntegratorsThatDoNotFeelIt) {
  FemPlan plan = plan_of(make_body(box_mesh(Vec3::Zero(), Vec3::Ones(), 1, 1, 1), ElasticModel::micropolar, 1e4, 0.3));
  plan.settings.rotation_update = RotationUpdate::exponential;
  plan.settings.integrator = Integrator::bdf2;
  const Result<std::unique_ptr<FemSimulation>> made = FemSimulation::create(plan, 1, native_isa());
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().message.find("rotation_update"), std::string::npos);
}

} // namespace
} // namespace wry::fem
