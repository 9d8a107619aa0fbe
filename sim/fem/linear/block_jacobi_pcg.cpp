#include <algorithm>
#include <cmath>

#include "sim/fem/linear/conjugate_gradients.h"

namespace wry::fem {

namespace {

/// Below this relative residual float arithmetic is not worth trying.
constexpr double SINGLE_TOLERANCE = 3e-5;

class BlockJacobiPcg final : public LinearMethod {
public:
  BlockJacobiPcg(const Threads& threads, int most_iterations)
      : m_threads(threads)
      , m_most_iterations(most_iterations) {}

  SolveReport solve(const LinearProblem& problem, std::vector<double>& solution) override {
    // Beyond this many iterations a direction is not worth its cost: Newton does better with what is there.
    const int worth = 200 + static_cast<int>(20.0 * std::cbrt(static_cast<double>(problem.right_side.size()))) * 5;
    const int limit = std::min(worth, m_most_iterations);
    int spent = 0;
    if (problem.tolerance >= SINGLE_TOLERANCE) {
      if (m_single.update(problem.matrix, m_threads)) {
        SolveReport report = conjugate_gradients<float>(problem.matrix, m_single, problem.right_side, problem.tolerance,
                                                        limit, m_single_work, m_threads, solution);
        if (report.end == SolveEnd::solved)
          return report;
        spent = report.iterations; // round-off of float can look like negative curvature: ask again in double
        if (spent >= m_most_iterations)
          return report;
      }
    }
    SolveReport report;
    report.end = SolveEnd::indefinite;
    report.relative_residual = 1.0;
    if (m_double.update(problem.matrix, m_threads))
      report = conjugate_gradients<double>(problem.matrix, m_double, problem.right_side, problem.tolerance,
                                           std::min(5 * worth, m_most_iterations - spent), m_double_work, m_threads,
                                           solution);
    report.iterations += spent;
    return report;
  }

private:
  const Threads& m_threads;
  int m_most_iterations;
  BlockJacobi<float> m_single;
  BlockJacobi<double> m_double;
  ConjugateGradientVectors<float> m_single_work;
  ConjugateGradientVectors<double> m_double_work;
};

} // namespace

std::unique_ptr<LinearMethod> make_block_jacobi_pcg(const BlockMatrix&, const Threads& threads, int most_iterations) {
  return std::make_unique<BlockJacobiPcg>(threads, most_iterations);
}

} // namespace wry::fem
