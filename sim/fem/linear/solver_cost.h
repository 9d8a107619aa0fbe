#pragma once

#include "sim/fem/fem_plan.h"
#include "sim/fem/linear/sparse_factor.h"

namespace wry::fem {

// Rates of one core, measured once on the reference machine. They enter decisions, so they are constants: what a
// machine happens to reach today must not change results.

/// Seconds of one factorisation.
double factor_seconds(const FactorCost& cost);
/// Seconds of one solve with the factor.
double factor_solve_seconds(const FactorCost& cost);
/// Seconds of one iteration preconditioned by a factor: a solve and a product in double.
double iteration_seconds(const FactorCost& cost, double matrix_entries);
/// Seconds of one block-Jacobi iteration in float.
double block_jacobi_seconds(double matrix_entries, double unknowns);

/// What the choice of a solver rests on.
struct SolverDemand {
  FactorCost cost; ///< zero when there is no factor to be had
  bool factor_available = true;
  double matrix_entries = 0.0; ///< stored
  double unknowns = 0.0;
  double wave_crossing = 0.0; ///< largest c dt / h of the bodies: sound speed, step, edge
  /// Largest reach of a turn of one microrotation, in edges: curvature energy makes its neighbours turn along, without
  /// inertia that would hold them back.
  double rotation_reach = 0.0;
  double longest_path = 0.0; ///< largest number of edges across a body
  bool contacts = false;     ///< bodies may touch each other or themselves: entries of the matrix come and go
};

/// Predicted time of one Newton direction by a solver [s].
double seconds_per_direction(LinearSolver solver, const SolverDemand& demand);

/// A solver and the reason in words for `wry plan`.
struct SolverDecision {
  LinearSolver solver = LinearSolver::pcg;
  std::string reason;
  double seconds_per_direction = 0.0; ///< predicted
  /// With pcg: as many iterations as a factor costs. A direction that takes more is left to one. 0: there is none.
  int iterations_worth_a_factor = 0;
};
SolverDecision choose_solver(const SolverDemand& demand);

} // namespace wry::fem
