#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/extreme_table.h"
#include "tests/fem/solid_support.h"

namespace wry::fem {
namespace {

using namespace test;

double least_height(const FemSimulation& simulation, const scene::PlaneCollider& plane) {
  return ((positions_of(simulation).rowwise() - plane.point.transpose()) * plane.normal).minCoeff();
}

FemPlan block_on_ground(double height, double friction) {
  FemPlan plan = plan_of(
      make_body(box_mesh(Vec3(0, height, 0), Vec3(0.2, 0.1, 0.2), 4, 2, 4), ElasticModel::neo_hookean, 1e6, 0.3));
  plan.gravity = Vec3(0, -9.81, 0);
  plan.planes.push_back({"ground", Vec3::Zero(), Vec3::UnitY(), friction});
  return plan;
}

TEST(FemContact, ABlockThatTouchesTheGroundRestsOnIt) {
  const FemPlan plan = block_on_ground(0.0, 0.0);
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  StepStats last;
  while (simulation->time() < 1.0) {
    const Result<StepStats> stats = simulation->step(1.0);
    ASSERT_TRUE(stats) << stats.error().message;
    last = *stats;
    ASSERT_GT(last.least_distance, 0.0);
  }
  EXPECT_LT(least_height(*simulation, plan.planes[0]), 2e-3);
  EXPECT_LT(last.kinetic_energy, 1e-6);
  EXPECT_EQ(last.contacts, 25);
}

TEST(FemContact, NoNodePassesThePlaneAtAnySpeed) {
  for (const double speed : {10.0, 100.0, 1000.0}) {
    FemPlan plan = block_on_ground(0.3, 0.0);
    plan.bodies[0].initial_velocity = Vec3(0, -speed, 0);
    plan.settings.max_time_step = 1.0 / 24.0;
    const std::unique_ptr<FemSimulation> simulation = simulate(plan);
    while (simulation->time() < 0.25) {
      const Result<StepStats> stats = simulation->step(0.25);
      ASSERT_TRUE(stats) << speed << " m/s: " << stats.error().message;
      ASSERT_GT(least_height(*simulation, plan.planes[0]), 0.0) << speed << " m/s";
    }
  }
}

struct Slide {
  double way = 0.0;          ///< down the slope after one second [m]
  double speed_gained = 0.0; ///< between half a second and one [m/s]
};

/// A block put on a slope of tan = 0.5.
Slide slide(double friction) {
  FemPlan plan = block_on_ground(0.0, friction);
  const double angle = std::atan(0.5);
  plan.gravity = 9.81 * Vec3(std::sin(angle), -std::cos(angle), 0);
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  const double start = positions_of(*simulation).col(0).mean();
  int steps = run_until(*simulation, 0.5);
  const double speed = channel_of(*simulation, "velocity").col(0).mean();
  steps += run_until(*simulation, 1.0);
  wry::test::note_extreme("contact", fmt::format("friction {:g} on a slope of tan 0.5", friction),
                          {"holds", steps, 0, 0, 0.0, ""});
  return {positions_of(*simulation).col(0).mean() - start, channel_of(*simulation, "velocity").col(0).mean() - speed};
}

TEST(FemContact, ABlockOnASlopeSticksIfFrictionReachesTheTangent) {
  // Below the tangent it gains g (sin - mu cos) = 0.0877 m/s each second; at the tangent it keeps what speed it got
  // when it settled; above it comes to rest, creeping at a share of the friction velocity.
  EXPECT_NEAR(slide(0.49).speed_gained, 0.0439, 0.002);
  EXPECT_NEAR(slide(0.5).speed_gained, 0.0, 5e-4);
  EXPECT_LT(slide(0.51).way, 2e-3);
  EXPECT_LT(slide(1.0).way, 1e-3);
  EXPECT_LT(slide(10.0).way, 1e-3);
  EXPECT_NEAR(slide(0.0).speed_gained, 0.5 * 9.81 * std::sin(std::atan(0.5)), 0.01);
}

TEST(FemContact, ABodyBelowThePlaneIsRefusedByName) {
  const FemPlan plan = block_on_ground(-0.01, 0.0);
  const Result<std::unique_ptr<FemSimulation>> simulation = FemSimulation::create(plan, 1, native_isa());
  ASSERT_FALSE(simulation);
  EXPECT_EQ(simulation.error().code, ErrorCode::bad_input);
  EXPECT_NE(simulation.error().message.find("ground"), std::string::npos);
}

} // namespace
} // namespace wry::fem
