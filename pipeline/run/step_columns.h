#pragma once

#include <string>
#include <vector>

#include "sim/fem/fem_simulation.h"
#include "sim/mpm/mpm_simulation.h"
#include "sim/sim_plan.h"

namespace wry::pipeline {

/// The table stats.csv: a row per step of either method. It has the columns of the methods that the plan uses; a row
/// leaves those of the other method not a number.
class StepColumns {
public:
  explicit StepColumns(const SimPlan& plan);

  /// Names, with units where they have one.
  std::vector<std::string> names() const;
  std::vector<double> row(int step, const fem::StepStats& stats) const;
  std::vector<double> row(int step, const mpm::StepStats& stats) const;

private:
  bool m_solids, m_particles;
};

/// Sums over the steps of a run, for summary.json and the last line on the terminal.
struct StepTotals {
  int steps = 0; ///< of solids
  int newton_iterations = 0;
  int linear_iterations = 0;
  int cuts = 0;
  int projected_elements = 0;
  int most_contacts = 0;
  double smallest_dt = 0.0;
  double least_distance = 0.0;
  double worst_residual = 0.0;
  double evaluate_ms = 0.0, assemble_ms = 0.0, solve_ms = 0.0, total_ms = 0.0;

  struct Particles {
    int steps = 0;
    double particle_steps = 0.0;
    double grain_updates = 0.0;
    double smallest_dt = 0.0;
    int by_limit[5] = {}; ///< steps that each mpm::StepLimit bound
    int cut = 0;          ///< steps shorter than the one given by hand
    double scatter_ms = 0.0, grid_ms = 0.0, gather_ms = 0.0, sort_ms = 0.0, grains_ms = 0.0, total_ms = 0.0;
  } particles;

  void add(const fem::StepStats& stats);
  void add(const mpm::StepStats& stats);
};

} // namespace wry::pipeline
