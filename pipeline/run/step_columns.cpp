#include "pipeline/run/step_columns.h"

#include <algorithm>
#include <array>

namespace wry::pipeline {

namespace {

struct Column {
  const char* name;
  double (*value)(const fem::StepStats&);
};

using Stats = fem::StepStats;
constexpr std::array COLUMNS = {
    Column{"time_s", [](const Stats& s) { return s.time; }},
    Column{"dt_s", [](const Stats& s) { return s.dt; }},
    Column{"newton_iterations", [](const Stats& s) { return double(s.newton_iterations); }},
    Column{"linear_iterations", [](const Stats& s) { return double(s.linear_iterations); }},
    Column{"line_search_halvings", [](const Stats& s) { return double(s.line_search_halvings); }},
    Column{"projected_elements", [](const Stats& s) { return double(s.projected_elements); }},
    Column{"cuts", [](const Stats& s) { return double(s.cuts); }},
    Column{"contacts", [](const Stats& s) { return double(s.contacts); }},
    Column{"least_distance_m", [](const Stats& s) { return s.least_distance; }},
    Column{"residual_Ns", [](const Stats& s) { return s.residual; }},
    Column{"kinetic_energy_J", [](const Stats& s) { return s.kinetic_energy; }},
    Column{"elastic_energy_J", [](const Stats& s) { return s.elastic_energy; }},
    Column{"curvature_energy_J", [](const Stats& s) { return s.curvature_energy; }},
    Column{"gravity_energy_J", [](const Stats& s) { return s.gravity_energy; }},
    Column{"evaluate_ms", [](const Stats& s) { return s.evaluate_ms; }},
    Column{"assemble_ms", [](const Stats& s) { return s.assemble_ms; }},
    Column{"solve_ms", [](const Stats& s) { return s.solve_ms; }},
    Column{"total_ms", [](const Stats& s) { return s.total_ms; }},
};

} // namespace

std::vector<std::string> step_columns() {
  std::vector<std::string> names = {"step"};
  for (const Column& column : COLUMNS)
    names.emplace_back(column.name);
  return names;
}

std::vector<double> step_row(int step, const fem::StepStats& stats) {
  std::vector<double> row = {static_cast<double>(step)};
  for (const Column& column : COLUMNS)
    row.push_back(column.value(stats));
  return row;
}

void StepTotals::add(const fem::StepStats& stats) {
  smallest_dt = steps == 0 ? stats.dt : std::min(smallest_dt, stats.dt);
  least_distance = steps == 0 ? stats.least_distance : std::min(least_distance, stats.least_distance);
  ++steps;
  newton_iterations += stats.newton_iterations;
  linear_iterations += stats.linear_iterations;
  cuts += stats.cuts;
  projected_elements += stats.projected_elements;
  most_contacts = std::max(most_contacts, stats.contacts);
  worst_residual = std::max(worst_residual, stats.residual);
  evaluate_ms += stats.evaluate_ms;
  assemble_ms += stats.assemble_ms;
  solve_ms += stats.solve_ms;
  total_ms += stats.total_ms;
}

} // namespace wry::pipeline
