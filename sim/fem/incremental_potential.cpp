#include "sim/fem/incremental_potential.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/fem/rotation_update.h"

namespace wry::fem {

void IncrementalPotential::evaluate(const Trial& trial, Evaluation& out) const {
  out.energy = out.magnitude = 0.0;
  out.gradient.assign(m_problem.model.layout.dof_count(), 0.0);
  add_terms(trial, true, out);
  if (m_stage.exponential) {
    out.gradient_by_increments = out.gradient;
    chain_gradient(m_problem.model.layout, m_stage, trial, out.gradient);
  }
  add_terms(trial, false, out);
  double sum = 0.0;
  for (std::size_t i = 0; i < out.gradient.size(); ++i) {
    if (m_problem.held[i])
      out.gradient[i] = 0.0;
    sum += out.gradient[i] * out.gradient[i];
  }
  out.residual = std::sqrt(sum);
}

void IncrementalPotential::add_terms(const Trial& trial, bool on_increments, Evaluation& out) const {
  for (const EnergyTerm* term : m_problem.terms) {
    if (term->acts_on_increments() != on_increments)
      continue;
    const double energy = term->add_gradient(m_stage, trial, out.gradient);
    out.energy += energy;
    out.magnitude += std::abs(energy);
  }
}

int IncrementalPotential::sum_matrix(const Trial& trial, const Evaluation& now, Projection projection) {
  m_problem.matrix.set_zero(m_problem.threads);
  int projected = 0;
  for (const bool on_increments : {true, false}) {
    for (const EnergyTerm* term : m_problem.terms) {
      if (term->acts_on_increments() == on_increments)
        projected += term->add_hessian(m_stage, trial, projection, m_problem.matrix);
    }
    if (on_increments && m_stage.exponential)
      chain_hessian(m_stage, trial, now.gradient_by_increments, m_problem.matrix);
  }
  m_problem.matrix.finish_pairs();
  return projected;
}

double IncrementalPotential::hold_matrix(const Trial& trial) {
  const double round_off_floor = estimate_floor(trial);
  m_problem.matrix.hold(m_problem.held, m_problem.threads);
  m_problem.matrix.update_single(m_problem.threads);
  return round_off_floor;
}

/// How large the residual can be from rounding positions and momenta alone: each force is a stiffness times a position.
double IncrementalPotential::estimate_floor(const Trial& trial) {
  const FemModel& model = m_problem.model;
  m_problem.matrix.diagonal(m_diagonal);
  double sum = 0.0;
  for (int node = 0; node < model.layout.node_count(); ++node) {
    const double place = trial.positions.row(node).norm();
    const double momentum =
        model.mass[node] * (trial.velocities.row(node).norm() + m_stage.beta * model.gravity.norm());
    for (int i = 0; i < model.layout.dofs(node); ++i) {
      const std::size_t dof = model.layout.dof(node) + i;
      if (m_problem.held[dof])
        continue;
      double noise = 0.0;
      if (i < 3) {
        noise = std::max(0.0, m_diagonal[dof] - model.mass[node]) / m_stage.beta * place + momentum;
      } else {
        const double coupling = std::sqrt(std::abs(m_diagonal[dof] * m_diagonal[dof - 3]));
        noise = (std::abs(m_diagonal[dof]) + coupling * place) / m_stage.beta;
      }
      sum += noise * noise;
    }
  }
  return std::numeric_limits<double>::epsilon() * std::sqrt(sum);
}

void IncrementalPotential::add_shift(double share) {
  for (BlockMatrix::Section& section : m_problem.matrix.sections()) {
    const int d = section.nodes.dofs;
    for (int node = 0; node < section.nodes.node_count; ++node) {
      double* block = section.values.data() + section.row_begin[node] * d * d;
      for (int i = 0; i < d; ++i)
        block[i * d + i] += share * std::abs(block[i * d + i]) + std::numeric_limits<double>::min();
    }
  }
  m_problem.matrix.update_single(m_problem.threads);
}

} // namespace wry::fem
