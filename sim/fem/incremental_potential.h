#pragma once

#include <vector>

#include "sim/fem/newton.h"

namespace wry::fem {

/// The sum of the terms at a trial.
struct Evaluation {
  double energy = 0.0;
  double magnitude = 0.0; ///< sum of |terms|, the scale of round-off
  double residual = 0.0;  ///< |gradient| over free unknowns
  std::vector<double> gradient;
  std::vector<double> gradient_by_increments; ///< of the exponential update, before its chain; else empty
};

/// What a step minimises, with its gradient and its matrix. Terms that act on increments are summed first, since an
/// exponential update chains what they give.
class IncrementalPotential {
public:
  IncrementalPotential(const NewtonProblem& problem, const Stage& stage)
      : m_problem(problem)
      , m_stage(stage) {}

  void evaluate(const Trial& trial, Evaluation& out) const;
  /// Sums the Hessians into the problem's matrix, of which held unknowns are still a part; `now` is what the trial was
  /// evaluated to. Returns how many elements were projected.
  int sum_matrix(const Trial& trial, const Evaluation& now, Projection projection);
  /// Takes the held unknowns out of the matrix. Returns the round-off of the residual.
  double hold_matrix(const Trial& trial);
  /// Adds this share of its diagonal to the matrix: the last resort when even projected elements leave one that is not
  /// positive definite in floating point.
  void add_shift(double share);

private:
  void add_terms(const Trial& trial, bool on_increments, Evaluation& out) const;
  double estimate_floor(const Trial& trial);

  const NewtonProblem& m_problem;
  const Stage& m_stage;
  std::vector<double> m_diagonal;
};

} // namespace wry::fem
