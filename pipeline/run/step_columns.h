#pragma once

#include <string>
#include <vector>

#include "sim/fem/fem_simulation.h"

namespace wry::pipeline {

/// Column names of stats.csv, with units where they have one.
std::vector<std::string> step_columns();

/// A row of stats.csv, in the order of step_columns().
std::vector<double> step_row(int step, const fem::StepStats& stats);

/// Sums over the steps of a run, for summary.json and the last line on the terminal.
struct StepTotals {
  int steps = 0;
  int newton_iterations = 0;
  int linear_iterations = 0;
  int cuts = 0;
  int projected_elements = 0;
  int most_contacts = 0;
  double smallest_dt = 0.0;
  double least_distance = 0.0;
  double worst_residual = 0.0;
  double evaluate_ms = 0.0, assemble_ms = 0.0, solve_ms = 0.0, total_ms = 0.0;

  void add(const fem::StepStats& stats);
};

} // namespace wry::pipeline
