#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim/fem/linear/linear_method.h"
#include "sim/fem/terms/energy_term.h"

namespace wry::fem {

/// When to stop, and how exactly to solve on the way.
struct NewtonSettings {
  double tolerance = 1e-8; ///< of |gradient| over the free unknowns
  int max_iterations = 60;
  double linear_tolerance = 0.0;   ///< relative; 0: as much as the progress deserves
  double relative_tolerance = 0.0; ///< enough, too, as a share of the residual at the start
};

/// What a minimisation did.
struct NewtonReport {
  bool converged = false;
  int iterations = 0; ///< linear systems that led to a step
  int linear_iterations = 0;
  int halvings = 0;
  int projected_elements = 0;
  double residual = 0.0;        ///< |gradient| at the end
  double round_off_floor = 0.0; ///< below this the residual is noise
  std::string trouble;          ///< why it did not converge, in words
  double evaluate_ms = 0.0, assemble_ms = 0.0, solve_ms = 0.0;
};

/// NewtonReport::trouble where nothing could even begin.
inline constexpr const char* ENERGY_NOT_FINITE = "the energy is not finite at the start of the step";

/// The work of both; convergence, residual and trouble are those of the later one.
NewtonReport sum_of(const NewtonReport& earlier, const NewtonReport& later);

/// What is minimised, and with what; all owned by the simulation.
struct NewtonProblem {
  const FemModel& model;
  const std::vector<EnergyTerm*>& terms;
  const std::vector<char>& held; ///< packed; nonzero: this unknown keeps the value it has in the trial
  BlockMatrix& matrix;
  LinearMethod& linear;
  const Threads& threads;
  std::function<const std::vector<Mat3>&(const Trial&)> node_rotations;
  /// Where held unknowns have to be at the end, where the trial does not have them there yet: they are taken along with
  /// the directions, as far as obstacles and the matter allow. nullptr: they are there.
  const Trial* given = nullptr;
};

/// Fills positions and increments from the velocities of a trial.
void update_trial(const Stage& stage, Trial& trial);

/// Minimises the sum of the terms from `trial`, where the energy must be finite. Exact Hessians first; element Hessians
/// are projected when negative curvature turns up. The trial is a minimiser only if the report says converged.
NewtonReport minimise(const NewtonProblem& problem, const NewtonSettings& settings, const Stage& stage, Trial& trial);

} // namespace wry::fem
