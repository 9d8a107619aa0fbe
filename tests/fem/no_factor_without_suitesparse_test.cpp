#include <memory>

#include <gtest/gtest.h>

#include "sim/fem/fem_simulation.h"
#include "sim/geometry/structured_tets.h"

namespace wry::fem {
namespace {

TEST(NoFactor, ADirectSolverNamesTheOptionThatBringsItBack) {
  FemPlan plan;
  FemBody body;
  body.name = "cube";
  body.mesh = std::make_shared<const geometry::TetMesh>(
      *geometry::make_block_tets(geometry::box_block(Vec3::Ones()), {{1, 1, 1}, geometry::CellSplit::five}));
  plan.bodies.push_back(body);
  plan.settings.linear_solver = LinearSolver::cholesky;
  const Result<std::unique_ptr<FemSimulation>> made = FemSimulation::create(plan, 1, native_isa());
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::unavailable);
  EXPECT_NE(made.error().message.find("WRY_WITH_SUITESPARSE"), std::string::npos) << made.error().message;
}

} // namespace
} // namespace wry::fem
