#include <gtest/gtest.h>

#include "tests/fem/solid_support.h"
#include "tests/fem/solvers_of_this_build.h"

namespace wry::fem {
namespace {

using namespace test;

/// A beam that bends under gravity until it meets the ground; optionally with microrotations.
FemPlan sagging_beam(ElasticModel model, LinearSolver solver) {
  const std::shared_ptr<const geometry::TetMesh> mesh = box_mesh(Vec3(0, 0.1, 0), Vec3(1.0, 0.1, 0.1), 12, 2, 2);
  FemPlan plan = plan_of(make_body(mesh, model, 2e4, 0.3));
  plan.gravity = Vec3(0, -9.81, 0);
  plan.planes.push_back({"ground", Vec3::Zero(), Vec3::UnitY(), 0.3});
  plan.fixed.push_back({"clamp", 0, vertices_at(*mesh, 0, 0.0), true, true, 0.15});
  plan.settings.linear_solver = solver;
  if (model == ElasticModel::micropolar) {
    FemMaterial& material = plan.bodies[0].material;
    material.curvature = CurvatureModel::isotropic;
    material.length_scale = 0.02;
    material.rotary_inertia = 0.01;
    plan.bodies[0].rest_curvature = [](const RestPlace& place, double time) {
      Mat3 curvature = Mat3::Zero();
      curvature(2, 0) = time * place.position[0];
      return curvature;
    };
  }
  return plan;
}

struct Case {
  const char* name;
  ElasticModel model;
  LinearSolver solver;
};

class FemResume : public ::testing::TestWithParam<Case> {};

std::uint64_t run_and_hash(FemSimulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) {
    const Result<StepStats> stats = simulation.step(10.0);
    EXPECT_TRUE(stats) << stats.error().message;
  }
  return hash_of(simulation.archive());
}

TEST_P(FemResume, IsBitIdenticalInAFreshObject) {
  const FemPlan plan = sagging_beam(GetParam().model, GetParam().solver);
  const std::unique_ptr<FemSimulation> through = simulate(plan);
  const std::uint64_t halfway = run_and_hash(*through, 15);
  const StateArchive archive = through->archive();
  const std::uint64_t expected = run_and_hash(*through, 15);
  ASSERT_NE(halfway, expected);
  const std::unique_ptr<FemSimulation> resumed = simulate(plan);
  const Status status = resumed->restore(archive);
  ASSERT_TRUE(status) << status.error().message;
  EXPECT_EQ(hash_of(resumed->archive()), halfway);
  EXPECT_EQ(run_and_hash(*resumed, 15), expected);
}

TEST_P(FemResume, ThreadsDoNotChangeABit) {
  const FemPlan plan = sagging_beam(GetParam().model, GetParam().solver);
  const std::uint64_t expected = run_and_hash(*simulate(plan, 1), 20);
  for (const int threads : {2, 3, 8})
    EXPECT_EQ(run_and_hash(*simulate(plan, threads), 20), expected) << threads << " threads";
}

std::vector<Case> cases_of_this_build() {
  std::vector<Case> cases;
  for (const LinearSolver solver : solvers_of_this_build()) {
    const char* const names[][2] = {{"ClassicPcg", "MicropolarPcg"},
                                    {"ClassicCholesky", "MicropolarCholesky"},
                                    {"ClassicStale", "MicropolarStale"}};
    const int row = solver == LinearSolver::pcg ? 0 : solver == LinearSolver::cholesky ? 1 : 2;
    cases.push_back({names[row][0], ElasticModel::neo_hookean, solver});
    cases.push_back({names[row][1], ElasticModel::micropolar, solver});
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Methods, FemResume, ::testing::ValuesIn(cases_of_this_build()),
                         [](const ::testing::TestParamInfo<Case>& tested) { return std::string(tested.param.name); });

TEST(FemRestore, RefusesTheCheckpointOfAnotherShot) {
  const std::unique_ptr<FemSimulation> simulation =
      simulate(sagging_beam(ElasticModel::neo_hookean, LinearSolver::pcg));
  StateArchive archive = simulation->archive();
  for (NamedArray& array : archive) {
    if (array.name == "fem/body0/positions")
      array.values.pop_back();
  }
  const Status status = simulation->restore(archive);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::io);
  EXPECT_NE(status.error().message.find("fem/body0/positions"), std::string::npos);
}

} // namespace
} // namespace wry::fem
