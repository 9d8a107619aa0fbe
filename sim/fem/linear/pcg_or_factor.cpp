#include <utility>

#include "sim/fem/linear/linear_method.h"

namespace wry::fem {

namespace {

/// After a hand-over this many directions are left to the factor before iterations are tried again.
constexpr int DIRECTIONS_BY_FACTOR = 64;

class PcgOrFactor final : public LinearMethod {
public:
  PcgOrFactor(const BlockMatrix& matrix, const Threads& threads, int iterations_worth_a_factor)
      : m_matrix(matrix)
      , m_threads(threads)
      , m_pcg(make_block_jacobi_pcg(matrix, threads, iterations_worth_a_factor))
      , m_most_iterations(iterations_worth_a_factor) {}

  SolveReport solve(const LinearProblem& problem, std::vector<double>& solution) override {
    SolveReport report;
    if (m_left_to_factor == 0) {
      report = m_pcg->solve(problem, solution);
      if (report.end != SolveEnd::unfinished || report.iterations < m_most_iterations)
        return report;
      m_left_to_factor = DIRECTIONS_BY_FACTOR;
    }
    --m_left_to_factor;
    if (!have_factor())
      return report;
    const int spent = report.iterations;
    report = m_factor->solve(problem, solution);
    report.iterations += spent;
    return report;
  }

  void save(StateArchive& archive) const override {
    archive.push_back({"fem/left_to_factor", {1}, {static_cast<double>(m_left_to_factor)}});
    if (m_factor)
      m_factor->save(archive);
  }

  Status restore(const StateArchive& archive) override {
    m_left_to_factor = 0;
    bool factored = false;
    for (const NamedArray& array : archive) {
      if (array.name == "fem/left_to_factor" && array.values.size() == 1)
        m_left_to_factor = static_cast<int>(array.values[0]);
      factored = factored || array.name == "fem/stale/flags";
    }
    if (!factored || !have_factor())
      return {};
    return m_factor->restore(archive);
  }

  std::size_t memory_bytes() const override { return m_factor ? m_factor->memory_bytes() : 0; }

private:
  bool have_factor() {
    if (m_factor || m_refused)
      return m_factor != nullptr;
    Result<std::unique_ptr<LinearMethod>> made = make_stale_cholesky(m_matrix, m_threads);
    m_refused = !made;
    if (made)
      m_factor = std::move(made).value();
    return m_factor != nullptr;
  }

  const BlockMatrix& m_matrix;
  const Threads& m_threads;
  std::unique_ptr<LinearMethod> m_pcg;
  std::unique_ptr<LinearMethod> m_factor; ///< made when it is first needed
  int m_most_iterations;
  int m_left_to_factor = 0;
  bool m_refused = false; ///< there is no memory for a factor
};

} // namespace

std::unique_ptr<LinearMethod> make_pcg_or_factor(const BlockMatrix& matrix, const Threads& threads,
                                                 int iterations_worth_a_factor) {
  return std::make_unique<PcgOrFactor>(matrix, threads, iterations_worth_a_factor);
}

} // namespace wry::fem
