#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/fem/solid_support.h"

namespace wry::fem {
namespace {

using namespace test;

Vec3 sum_of(const FemSimulation& simulation, const char* channel, const std::vector<std::int32_t>& nodes) {
  const Eigen::MatrixXd rows = channel_of(simulation, channel);
  Vec3 sum = Vec3::Zero();
  for (const std::int32_t node : nodes)
    sum += rows.row(node).transpose();
  return sum;
}

FemPlan block(ElasticModel model) {
  FemPlan plan = plan_of(make_body(box_mesh(Vec3::Zero(), Vec3(0.1, 0.1, 0.1), 2, 2, 2), model, 1e5, 0.3));
  plan.bodies[0].material.mass_damping = 100.0;
  plan.outputs.reactions = true;
  return plan;
}

TEST(Reaction, AHangingBlockPullsByItsWeight) {
  for (const ElasticModel model : {ElasticModel::neo_hookean, ElasticModel::micropolar}) {
    FemPlan plan = block(model);
    plan.gravity = Vec3(0, -10, 0); // 1 kg
    const std::vector<std::int32_t> top = vertices_at(*plan.bodies[0].mesh, 1, 0.1);
    plan.fixed.push_back({"top", 0, top, true, true, {}});
    const std::unique_ptr<FemSimulation> simulation = simulate(plan);
    run_until(*simulation, 1.0);
    EXPECT_LT((sum_of(*simulation, "reaction_force", top) - Vec3(0, 10, 0)).norm(), 1e-3);
    const Eigen::MatrixXd all = channel_of(*simulation, "reaction_force");
    EXPECT_LT((all.colwise().sum().transpose() - Vec3(0, 10, 0)).norm(), 1e-3) << "free nodes have none";
  }
}

TEST(Reaction, ADrivenBodyIsPulledByItsMassTimesItsAccelerationWithEveryIntegrator) {
  for (const Integrator integrator : {Integrator::backward_euler, Integrator::bdf2, Integrator::sdirk2}) {
    // Every node is driven, so that the block is rigid: x = 3 s^2 - 2 s^3 metres, 6 m/s^2 at the start.
    FemPlan plan = block(ElasticModel::micropolar);
    plan.bodies[0].material.mass_damping = 0.0;
    plan.settings.integrator = integrator;
    plan.settings.max_time_step = 0.001;
    DrivenNodes drive;
    for (std::int32_t node = 0; node < plan.bodies[0].mesh->vertices.rows(); ++node)
      drive.nodes.push_back(node);
    drive.motion =
        scene::Motion::along_keys({{{0.0, Vec3::Zero()}, {1.0, Vec3(1, 0, 0)}}, Vec3::Zero(), scene::Ease::smooth})
            .value();
    plan.driven.push_back(drive);
    const std::unique_ptr<FemSimulation> simulation = simulate(plan);
    run_until(*simulation, 0.1);
    const double time = 0.1 - 0.001; // the change of the velocity between the middles of the last two steps
    EXPECT_NEAR(sum_of(*simulation, "reaction_force", drive.nodes)[0], 6.0 - 12.0 * time, 1e-3);
  }
}

TEST(Reaction, ATwistedShaftIsHeldByTheTorqueThatItsEnergyDemands) {
  // dW/d(angle) = torque, by differences of the energy of two runs; and both ends balance.
  const auto run = [](double degrees) {
    FemPlan plan = plan_of(
        make_body(box_mesh(Vec3(-0.05, -0.05, 0), Vec3(0.1, 0.1, 0.4), 2, 2, 6), ElasticModel::micropolar, 1e4, 0.3));
    FemMaterial& material = plan.bodies[0].material;
    material.length_scale = 0.05;
    material.curvature = CurvatureModel::isotropic;
    material.density = 1e-6;
    plan.settings.newton_tolerance = 1e-13;
    plan.settings.max_time_step = 0.1;
    plan.outputs.reactions = true;
    plan.fixed.push_back({"foot", 0, vertices_at(*plan.bodies[0].mesh, 2, 0.0), true, true, {}});
    DrivenNodes drive;
    drive.nodes = vertices_at(*plan.bodies[0].mesh, 2, 0.4);
    drive.motion =
        scene::Motion::along_keys(
            {{{0.0, Vec3::Zero(), Vec3::UnitZ(), 0.0}, {1.0, Vec3::Zero(), Vec3::UnitZ(), degrees}}, Vec3::Zero()})
            .value();
    plan.driven.push_back(drive);
    struct Outcome {
      double energy, torque, balance;
    };
    const std::unique_ptr<FemSimulation> simulation = simulate(plan);
    StepStats stats;
    while (simulation->time() < 1.0)
      stats = simulation->step(1.0).value();
    const Eigen::MatrixXd forces = channel_of(*simulation, "reaction_force");
    const Eigen::MatrixXd torques = channel_of(*simulation, "reaction_torque");
    const Points positions = positions_of(*simulation);
    const auto about_axis = [&](const std::vector<std::int32_t>& nodes) {
      double sum = 0.0;
      for (const std::int32_t node : nodes)
        sum += Vec3(positions.row(node)).cross(Vec3(forces.row(node)))[2] + torques(node, 2);
      return sum;
    };
    const double driven = about_axis(drive.nodes);
    return Outcome{stats.elastic_energy + stats.curvature_energy, driven, driven + about_axis(plan.fixed[0].nodes)};
  };
  constexpr double STEP = 0.5;
  const auto middle = run(40.0);
  const double slope = (run(40.0 + STEP).energy - run(40.0 - STEP).energy) / (2.0 * STEP * std::numbers::pi / 180.0);
  EXPECT_NEAR(middle.torque, slope, 2e-4 * slope);
  EXPECT_LT(std::abs(middle.balance), 1e-6 * middle.torque);
}

TEST(Reaction, ABodyTorqueTurnsAHeldEndByWhatItSums) {
  FemPlan plan = block(ElasticModel::micropolar);
  const geometry::TetMesh& mesh = *plan.bodies[0].mesh;
  const std::vector<std::int32_t> foot = vertices_at(mesh, 1, 0.0);
  plan.fixed.push_back({"foot", 0, foot, true, true, {}});
  FemLoad load;
  for (std::int32_t node = 0; node < mesh.vertices.rows(); ++node) {
    load.nodes.push_back(node);
    load.shares.push_back(1.0 / static_cast<double>(mesh.vertices.rows()));
  }
  load.torque = [](double) { return Vec3(0, 0.5, 0); };
  load.force = [](double) { return Vec3(2, 0, 0); };
  plan.loads.push_back(load);
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  run_until(*simulation, 2.0);
  EXPECT_LT((sum_of(*simulation, "reaction_force", foot) - Vec3(-2, 0, 0)).norm(), 2e-3);
  const Eigen::MatrixXd forces = channel_of(*simulation, "reaction_force");
  const Eigen::MatrixXd torques = channel_of(*simulation, "reaction_torque");
  const Points positions = positions_of(*simulation);
  Vec3 reaction = Vec3::Zero(), load_moment(0, 0.5, 0);
  for (const std::int32_t node : foot)
    reaction += Vec3(positions.row(node)).cross(Vec3(forces.row(node))) + torques.row(node).transpose();
  for (const std::int32_t node : load.nodes)
    load_moment += Vec3(positions.row(node)).cross(Vec3(2, 0, 0)) / static_cast<double>(mesh.vertices.rows());
  EXPECT_LT((reaction + load_moment).norm(), 2e-3);
}

} // namespace
} // namespace wry::fem
