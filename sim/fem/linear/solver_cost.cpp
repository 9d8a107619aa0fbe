#include "sim/fem/linear/solver_cost.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace wry::fem {

namespace {

constexpr double FACTOR_FLOPS_PER_SECOND = 10e9;
constexpr double FACTOR_ENTRIES_PER_SECOND = 120e6; // assembly of supernodes
constexpr double SOLVE_ENTRIES_PER_SECOND = 0.4e9;
constexpr double DOUBLE_ENTRIES_PER_SECOND = 3e9;
constexpr double SINGLE_ENTRIES_PER_SECOND = 7e9;
constexpr double VECTOR_UNKNOWNS_PER_SECOND = 1e9;

/// Block-Jacobi iterations that one Newton direction (relative residual about 1e-3) takes. Per edge that a turn reaches
/// sheet, plate and bunnies take 3 to 6; per edge that a wave crosses twisted bars and rods take 5 to 16.
double expected_iterations(const SolverDemand& demand) {
  constexpr double PER_EDGE_OF_A_WAVE = 9.0, PER_EDGE_OF_A_TURN = 5.0;
  const double asked = std::max(PER_EDGE_OF_A_WAVE * demand.wave_crossing, PER_EDGE_OF_A_TURN * demand.rotation_reach);
  return 6.0 + std::min(asked, PER_EDGE_OF_A_WAVE * 1.5 * demand.longest_path);
}

constexpr double STALE_ITERATIONS = 5.0;
constexpr double SOLVES_PER_STALE_FACTOR = 20.0;
/// What a direction by a factor costs more when contacts come and go: the pattern is analysed anew, and a stale factor
/// knows nothing of the new ones. Measured in the first impacts of shots/lotus_bowl.toml.
constexpr double COST_OF_CONTACTS = 2.6;

} // namespace

double factor_seconds(const FactorCost& cost) {
  return cost.flops / FACTOR_FLOPS_PER_SECOND + cost.entries / FACTOR_ENTRIES_PER_SECOND;
}

double factor_solve_seconds(const FactorCost& cost) {
  return cost.entries / SOLVE_ENTRIES_PER_SECOND;
}

double iteration_seconds(const FactorCost& cost, double matrix_entries) {
  return factor_solve_seconds(cost) + matrix_entries / DOUBLE_ENTRIES_PER_SECOND;
}

double block_jacobi_seconds(double matrix_entries, double unknowns) {
  return matrix_entries / SINGLE_ENTRIES_PER_SECOND + unknowns / VECTOR_UNKNOWNS_PER_SECOND;
}

double seconds_per_direction(LinearSolver solver, const SolverDemand& demand) {
  const double more = demand.contacts ? COST_OF_CONTACTS : 1.0;
  switch (solver) {
  case LinearSolver::cholesky:
    return more * (factor_seconds(demand.cost) + factor_solve_seconds(demand.cost));
  case LinearSolver::stale_cholesky:
    return more * (STALE_ITERATIONS * iteration_seconds(demand.cost, demand.matrix_entries) +
                   factor_seconds(demand.cost) / SOLVES_PER_STALE_FACTOR);
  case LinearSolver::pcg:
  case LinearSolver::automatic:
    break;
  }
  return expected_iterations(demand) * block_jacobi_seconds(demand.matrix_entries, demand.unknowns);
}

SolverDecision choose_solver(const SolverDemand& demand) {
  const double pcg = seconds_per_direction(LinearSolver::pcg, demand);
  if (!demand.factor_available)
    return {LinearSolver::pcg, fmt::format("{:.0f} unknowns; this build has no direct solver", demand.unknowns), pcg};
  const double direct = seconds_per_direction(LinearSolver::cholesky, demand);
  const double stale = seconds_per_direction(LinearSolver::stale_cholesky, demand);
  SolverDecision decision;
  decision.solver = LinearSolver::pcg;
  if (direct < pcg || stale < pcg)
    decision.solver = direct <= stale ? LinearSolver::cholesky : LinearSolver::stale_cholesky;
  decision.seconds_per_direction = decision.solver == LinearSolver::pcg ? pcg : std::min(direct, stale);
  const std::string turns = demand.rotation_reach > demand.wave_crossing
                                ? fmt::format(", a turn reaches {:.0f}", demand.rotation_reach)
                                : std::string();
  decision.reason =
      fmt::format("{:.0f} unknowns, a wave crosses {:.1f} edges in a step{}: per direction about {:.1f} ms by "
                  "pcg ({:.0f} iterations), {:.1f} ms by a factor ({:.1f} Gflop), {:.1f} ms by a stale one",
                  demand.unknowns, demand.wave_crossing, turns, 1e3 * pcg, expected_iterations(demand), 1e3 * direct,
                  1e-9 * demand.cost.flops, 1e3 * stale);
  if (demand.contacts)
    decision.reason += "; contacts come and go, which factors do not bear well";
  if (decision.solver == LinearSolver::pcg) {
    const double worth = direct / block_jacobi_seconds(demand.matrix_entries, demand.unknowns);
    decision.iterations_worth_a_factor = static_cast<int>(std::clamp(worth, 100.0, 1e6));
    decision.reason += fmt::format("; a direction that takes {} iterations is left to a factor of {:.0f} MB",
                                   decision.iterations_worth_a_factor, 8e-6 * demand.cost.entries);
  }
  return decision;
}

} // namespace wry::fem
