#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sim/base/rotation.h"
#include "tests/fem/solid_support.h"

namespace wry::fem {
namespace {

using namespace test;

/// A bar along x of 2 x 2 x 6 cells whose far end is twisted about x while the near end is held.
FemPlan twisted_bar(ElasticModel model, double degrees, double end) {
  FemPlan plan = plan_of(make_body(box_mesh(Vec3(0, -0.05, -0.05), Vec3(0.6, 0.1, 0.1), 6, 2, 2), model, 1e4, 0.3));
  const geometry::TetMesh& mesh = *plan.bodies[0].mesh;
  plan.fixed.push_back({"near", 0, vertices_at(mesh, 0, 0.0), true, true, {}});
  DrivenNodes drive;
  drive.name = "far";
  drive.nodes = vertices_at(mesh, 0, 0.6);
  drive.motion =
      scene::Motion::along_keys(
          {{{0.0, Vec3::Zero(), Vec3::UnitX(), 0.0}, {end, Vec3::Zero(), Vec3::UnitX(), degrees}}, Vec3::Zero()})
          .value();
  plan.driven.push_back(drive);
  return plan;
}

/// The largest distance of driven nodes from where the motion has them.
double drift(const FemPlan& plan, const FemSimulation& simulation) {
  const DrivenNodes& drive = plan.driven[0];
  const scene::Pose pose = drive.motion.pose(simulation.time());
  const Points positions = positions_of(simulation);
  double most = 0.0;
  for (const std::int32_t node : drive.nodes)
    most =
        std::max(most, (positions.row(node).transpose() - pose.apply(plan.bodies[0].mesh->vertices.row(node))).norm());
  return most;
}

TEST(Drive, ExactDrivesDoNotDriftHoweverManySteps) {
  FemPlan plan = twisted_bar(ElasticModel::micropolar, 90.0, 1.0);
  plan.settings.max_time_step = 0.01;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  EXPECT_EQ(run_until(*simulation, 1.0), 100);
  EXPECT_LT(drift(plan, *simulation), 1e-14);
  const Eigen::MatrixXd rotations = channel_of(*simulation, "microrotation");
  const Vec4 expected = quaternion_exponential(Vec3(std::numbers::pi / 2, 0, 0));
  for (const std::int32_t node : plan.driven[0].nodes)
    EXPECT_LT(rotation_distance(Vec4(rotations.row(node)), expected), 1e-6); // the channel is single precision
}

TEST(Drive, EveryIntegratorEndsWhereTheMotionSays) {
  for (const Integrator integrator : {Integrator::backward_euler, Integrator::bdf2, Integrator::sdirk2}) {
    FemPlan plan = twisted_bar(ElasticModel::micropolar, 60.0, 0.2);
    plan.settings.integrator = integrator;
    const std::unique_ptr<FemSimulation> simulation = simulate(plan);
    run_until(*simulation, 0.2);
    EXPECT_LT(drift(plan, *simulation), 1e-14);
    const Eigen::MatrixXd rotations = channel_of(*simulation, "microrotation");
    const Vec4 expected = quaternion_exponential(Vec3(std::numbers::pi / 3, 0, 0));
    EXPECT_LT(rotation_distance(Vec4(rotations.row(plan.driven[0].nodes[0])), expected), 1e-6);
  }
}

TEST(Drive, PenaltyDrivesFollowWithinAThousandthOfTheTwistsArc) {
  FemPlan plan = twisted_bar(ElasticModel::micropolar, 90.0, 1.0);
  plan.driven[0].method = DriveMethod::penalty;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  run_until(*simulation, 1.0);
  const double arc = 0.05 * std::numbers::pi / 2;
  EXPECT_LT(drift(plan, *simulation), 1e-3 * arc);
  EXPECT_GT(drift(plan, *simulation), 0.0);
}

TEST(Drive, ASoftDriveGivesWayByTheLoadOverItsStiffness) {
  FemPlan plan =
      plan_of(make_body(box_mesh(Vec3::Zero(), Vec3(0.1, 0.1, 0.1), 1, 1, 1), ElasticModel::neo_hookean, 1e6, 0.3));
  plan.gravity = Vec3(0, -10, 0); // the cube weighs 10 N
  DrivenNodes soft;
  soft.name = "spring";
  soft.nodes = {0, 1, 2, 3, 4, 5, 6, 7};
  soft.method = DriveMethod::soft;
  soft.stiffness = 200.0;
  plan.driven.push_back(soft);
  plan.bodies[0].material.mass_damping = 20.0;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  run_until(*simulation, 3.0);
  EXPECT_NEAR(positions_of(*simulation).col(1).mean(), 0.05 - 10.0 / 200.0, 1e-4);
}

TEST(Drive, ASoftTurningSpringCarriesATorqueOfItsStiffnessTimesTheSineOfItsAngle) {
  // The far end's microrotations are pulled by a spring to where they are not; nothing else acts, so that it comes to
  // rest where the matter of the bar balances it: at a stiffness far above the bar's, at the motion's own angle.
  FemPlan plan = twisted_bar(ElasticModel::micropolar, 20.0, 0.2);
  plan.driven[0].method = DriveMethod::soft;
  plan.driven[0].drive_positions = false;
  plan.driven[0].turning_stiffness = 1e4;
  plan.bodies[0].material.mass_damping = 20.0;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  run_until(*simulation, 0.5);
  const Eigen::MatrixXd rotations = channel_of(*simulation, "microrotation");
  const Vec4 expected = quaternion_exponential(Vec3(std::numbers::pi / 9, 0, 0));
  EXPECT_LT(rotation_distance(Vec4(rotations.row(plan.driven[0].nodes[0])), expected), 1e-3);
}

TEST(Drive, AStepIsCutWhereADriveTurnsTooFar) {
  FemPlan plan = twisted_bar(ElasticModel::micropolar, 90.0, 0.1);
  plan.settings.max_time_step = 0.1;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  EXPECT_EQ(run_until(*simulation, 0.1), 3); // 30 degrees each
  EXPECT_LT(drift(plan, *simulation), 1e-14);
}

TEST(Drive, StepsLandOnReleasesAndTheReleasedEndSpringsBack) {
  FemPlan plan = twisted_bar(ElasticModel::micropolar, 30.0, 0.03);
  plan.driven[0].until = 0.035;
  plan.settings.max_time_step = 0.02;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  std::vector<double> times;
  while (simulation->time() < 0.1) {
    ASSERT_TRUE(simulation->step(0.1));
    times.push_back(simulation->time());
  }
  EXPECT_NE(std::find(times.begin(), times.end(), 0.03), times.end());  // a corner of the motion
  EXPECT_NE(std::find(times.begin(), times.end(), 0.035), times.end()); // the release
  EXPECT_GT(drift(plan, *simulation), 1e-4);
}

/// The far end goes one and a half cells in a step, so that the last layer of cells would be inside out if the rest
/// stayed, whose energy is infinite then. It is taken along, and no step is cut.
TEST(Drive, TakesMatterAlongThatTheDriveAloneWouldTurnInsideOut) {
  for (const ElasticModel model : {ElasticModel::neo_hookean, ElasticModel::micropolar_neo_hookean}) {
    FemPlan plan = twisted_bar(model, 0.0, 1.0);
    plan.driven[0].motion = *scene::Motion::along_keys(
        {{{0.0, Vec3::Zero(), Vec3::UnitX(), 0.0}, {0.05, Vec3(-0.15, 0, 0), Vec3::UnitX(), 20.0}}, Vec3::Zero()});
    plan.settings.max_time_step = 0.05;
    const std::unique_ptr<FemSimulation> simulation = simulate(plan);
    const Result<StepStats> stats = simulation->step(0.05);
    ASSERT_TRUE(stats) << stats.error().message;
    EXPECT_EQ(stats->cuts, 0);
    EXPECT_EQ(stats->time, 0.05);
    EXPECT_LT(drift(plan, *simulation), 1e-14);
    EXPECT_LT(stats->residual, plan.settings.newton_tolerance);
  }
}

TEST(Drive, ManyTurnsAreFollowedWithoutLosingOne) {
  // Two and a half turns of a free bar, driven at one end alone, within half a second.
  FemPlan plan = twisted_bar(ElasticModel::micropolar, 900.0, 0.5);
  plan.fixed.clear();
  plan.settings.max_time_step = 0.05;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  EXPECT_GE(run_until(*simulation, 0.5), 30);
  EXPECT_LT(drift(plan, *simulation), 1e-14);
}

} // namespace
} // namespace wry::fem
