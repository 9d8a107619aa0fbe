#include "sim/fem/fem_simulation.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/fem/solid_support.h"

namespace wry::fem {
namespace {

using namespace test;

FemPlan falling_cube(ElasticModel model) {
  FemPlan plan = plan_of(make_body(box_mesh(Vec3(0, 1, 0), Vec3(1, 1, 1), 2, 2, 2), model, 1e5, 0.3));
  plan.bodies[0].initial_velocity = Vec3(1, 2, 0);
  plan.gravity = Vec3(0, -9.81, 0);
  return plan;
}

TEST(FemSimulation, FreeFallFollowsBackwardEulerExactly) {
  const FemPlan plan = falling_cube(ElasticModel::neo_hookean);
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  ASSERT_EQ(run_until(*simulation, 0.1), 10);
  EXPECT_EQ(simulation->time(), 0.1);
  // Backward Euler: v_n = v0 + n dt g, x_n = x0 + n dt v0 + dt^2 g n (n + 1) / 2.
  const Points expected =
      plan.bodies[0].mesh->vertices.rowwise() + Eigen::RowVector3d(0.1, 0.2 - 9.81 * 0.01 * 0.01 * 55.0, 0.0);
  EXPECT_LT((positions_of(*simulation) - expected).cwiseAbs().maxCoeff(), 1e-10);
  const Eigen::MatrixXd velocity = channel_of(*simulation, "velocity");
  EXPECT_LT((velocity.rowwise() - Eigen::RowVector3d(1.0, 2.0 - 0.981, 0.0)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(FemSimulation, StepsLandOnTheEndEvenly) {
  const std::unique_ptr<FemSimulation> simulation = simulate(falling_cube(ElasticModel::neo_hookean));
  EXPECT_EQ(run_until(*simulation, 1.0 / 24.0), 5);
  EXPECT_EQ(simulation->time(), 1.0 / 24.0);
}

} // namespace
} // namespace wry::fem
