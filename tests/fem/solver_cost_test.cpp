#include "sim/fem/linear/solver_cost.h"

#include <gtest/gtest.h>

namespace wry::fem {
namespace {

/// A soft bar of 9,000 micropolar tets at 10 ms.
SolverDemand soft_bar() {
  SolverDemand demand;
  demand.cost = {0.6e9, 3e6};
  demand.matrix_entries = 0.56e6;
  demand.unknowns = 13e3;
  demand.wave_crossing = 3.0;
  demand.longest_path = 45.0;
  return demand;
}

TEST(SolverCost, SoftSolidsIterate) {
  const SolverDecision decision = choose_solver(soft_bar());
  EXPECT_EQ(decision.solver, LinearSolver::pcg);
  EXPECT_NE(decision.reason.find("unknowns"), std::string::npos);
}

TEST(SolverCost, StiffThinBodiesGetAFactor) {
  SolverDemand demand = soft_bar();
  demand.wave_crossing = 300.0;
  EXPECT_NE(choose_solver(demand).solver, LinearSolver::pcg);
}

TEST(SolverCost, BigSolidCubesIterateHoweverStiff) {
  SolverDemand demand = soft_bar();
  demand.cost = {309e9, 200e6};
  demand.matrix_entries = 4.3e6;
  demand.unknowns = 93e3;
  demand.wave_crossing = 300.0;
  demand.longest_path = 40.0;
  EXPECT_EQ(choose_solver(demand).solver, LinearSolver::pcg);
}

TEST(SolverCost, WithoutAFactorThereIsOnlyIteration) {
  SolverDemand demand = soft_bar();
  demand.wave_crossing = 300.0;
  demand.factor_available = false;
  EXPECT_EQ(choose_solver(demand).solver, LinearSolver::pcg);
}

TEST(SolverCost, ContactsSpeakAgainstAFactor) {
  // Where a factor is a little cheaper than iterations, it no longer is when it has to be made anew for each contact.
  SolverDemand demand = soft_bar();
  LinearSolver without = LinearSolver::pcg;
  for (demand.wave_crossing = 1.0; without == LinearSolver::pcg && demand.wave_crossing < 1e6;) {
    demand.wave_crossing *= 1.1;
    demand.longest_path = demand.wave_crossing;
    without = choose_solver(demand).solver;
  }
  ASSERT_NE(without, LinearSolver::pcg);
  demand.contacts = true;
  const SolverDecision decision = choose_solver(demand);
  EXPECT_EQ(decision.solver, LinearSolver::pcg);
  EXPECT_NE(decision.reason.find("contacts come and go"), std::string::npos);
  demand.wave_crossing *= 10.0;
  demand.longest_path *= 10.0;
  EXPECT_NE(choose_solver(demand).solver, LinearSolver::pcg) << "but far beyond, it still is cheaper";
}

} // namespace
} // namespace wry::fem
