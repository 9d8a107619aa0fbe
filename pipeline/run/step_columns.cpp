#include "pipeline/run/step_columns.h"

#include <algorithm>
#include <array>
#include <limits>

namespace wry::pipeline {

namespace {

template <class Stats> struct Column {
  const char* name;
  double (*value)(const Stats&);
};

using Stats = fem::StepStats;
using Solid = Column<fem::StepStats>;
constexpr std::array SOLID_COLUMNS = {
    Solid{"time_s", [](const Stats& s) { return s.time; }},
    Solid{"dt_s", [](const Stats& s) { return s.dt; }},
    Solid{"newton_iterations", [](const Stats& s) { return double(s.newton_iterations); }},
    Solid{"linear_iterations", [](const Stats& s) { return double(s.linear_iterations); }},
    Solid{"line_search_halvings", [](const Stats& s) { return double(s.line_search_halvings); }},
    Solid{"projected_elements", [](const Stats& s) { return double(s.projected_elements); }},
    Solid{"cuts", [](const Stats& s) { return double(s.cuts); }},
    Solid{"contacts", [](const Stats& s) { return double(s.contacts); }},
    Solid{"least_distance_m", [](const Stats& s) { return s.least_distance; }},
    Solid{"residual_Ns", [](const Stats& s) { return s.residual; }},
    Solid{"kinetic_energy_J", [](const Stats& s) { return s.kinetic_energy; }},
    Solid{"elastic_energy_J", [](const Stats& s) { return s.elastic_energy; }},
    Solid{"curvature_energy_J", [](const Stats& s) { return s.curvature_energy; }},
    Solid{"gravity_energy_J", [](const Stats& s) { return s.gravity_energy; }},
    Solid{"evaluate_ms", [](const Stats& s) { return s.evaluate_ms; }},
    Solid{"assemble_ms", [](const Stats& s) { return s.assemble_ms; }},
    Solid{"solve_ms", [](const Stats& s) { return s.solve_ms; }},
    Solid{"contact_search_ms", [](const Stats& s) { return s.contact_search_ms; }},
    Solid{"safe_step_ms", [](const Stats& s) { return s.safe_step_ms; }},
    Solid{"total_ms", [](const Stats& s) { return s.total_ms; }},
};

// Those of the same name share a column.
using Particle = Column<mpm::StepStats>;
constexpr std::array PARTICLE_COLUMNS = {
    Particle{"time_s", [](const mpm::StepStats& s) { return s.time; }},
    Particle{"dt_s", [](const mpm::StepStats& s) { return s.dt; }},
    Particle{"limit", [](const mpm::StepStats& s) { return double(s.limit); }},
    Particle{"given_over_stable", [](const mpm::StepStats& s) { return s.given_over_stable; }},
    Particle{"particles", [](const mpm::StepStats& s) { return double(s.particles); }},
    Particle{"blocks", [](const mpm::StepStats& s) { return double(s.blocks); }},
    Particle{"sorted", [](const mpm::StepStats& s) { return s.sorted ? 1.0 : 0.0; }},
    Particle{"linear_iterations", [](const mpm::StepStats& s) { return double(s.linear_iterations); }},
    Particle{"max_speed_m_per_s", [](const mpm::StepStats& s) { return s.max_speed; }},
    Particle{"kinetic_energy_J", [](const mpm::StepStats& s) { return s.kinetic_energy; }},
    Particle{"sort_ms", [](const mpm::StepStats& s) { return s.sort_ms; }},
    Particle{"scatter_ms", [](const mpm::StepStats& s) { return s.scatter_ms; }},
    Particle{"grid_ms", [](const mpm::StepStats& s) { return s.grid_ms; }},
    Particle{"gather_ms", [](const mpm::StepStats& s) { return s.gather_ms; }},
    Particle{"grain_updates", [](const mpm::StepStats& s) { return double(s.grain_updates); }},
    Particle{"grains_ms", [](const mpm::StepStats& s) { return s.grains_ms; }},
    Particle{"total_ms", [](const mpm::StepStats& s) { return s.total_ms; }},
};

template <class Columns, class StepStats>
std::vector<double> values_of(const std::vector<std::string>& names, const Columns& columns, int step,
                              const StepStats& stats) {
  std::vector<double> row(names.size(), std::numeric_limits<double>::quiet_NaN());
  row.front() = step;
  for (const auto& column : columns) {
    const auto found = std::find(names.begin(), names.end(), column.name);
    row[static_cast<std::size_t>(found - names.begin())] = column.value(stats);
  }
  return row;
}

} // namespace

StepColumns::StepColumns(const SimPlan& plan)
    : m_solids(!plan.fem.bodies.empty())
    , m_particles(!plan.mpm.bodies.empty()) {}

std::vector<std::string> StepColumns::names() const {
  std::vector<std::string> names = {"step"};
  if (m_solids) {
    for (const Solid& column : SOLID_COLUMNS)
      names.emplace_back(column.name);
  }
  if (m_particles) {
    for (const Particle& column : PARTICLE_COLUMNS) {
      if (std::find(names.begin(), names.end(), column.name) == names.end())
        names.emplace_back(column.name);
    }
  }
  return names;
}

std::vector<double> StepColumns::row(int step, const fem::StepStats& stats) const {
  return values_of(names(), SOLID_COLUMNS, step, stats);
}

std::vector<double> StepColumns::row(int step, const mpm::StepStats& stats) const {
  return values_of(names(), PARTICLE_COLUMNS, step, stats);
}

void StepTotals::add(const mpm::StepStats& stats) {
  particles.smallest_dt = particles.steps == 0 ? stats.dt : std::min(particles.smallest_dt, stats.dt);
  ++particles.steps;
  particles.particle_steps += static_cast<double>(stats.particles);
  ++particles.by_limit[static_cast<int>(stats.limit)];
  particles.cut += stats.given_over_stable > 1.0 ? 1 : 0;
  particles.scatter_ms += stats.scatter_ms;
  particles.grid_ms += stats.grid_ms;
  particles.grains_ms += stats.grains_ms;
  particles.grain_updates += static_cast<double>(stats.grain_updates);
  particles.gather_ms += stats.gather_ms;
  particles.sort_ms += stats.sort_ms;
  particles.total_ms += stats.total_ms;
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
