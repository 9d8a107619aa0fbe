#include "sim/fem/linear/linear_method.h"
#include "sim/fem/linear/sparse_factor.h"

namespace wry::fem {

namespace {

class Cholesky final : public LinearMethod {
public:
  explicit Cholesky(std::unique_ptr<SparseFactor> factor)
      : m_factor(std::move(factor)) {}

  SolveReport solve(const LinearProblem& problem, std::vector<double>& solution) override {
    SolveReport report;
    if (!m_factor->factor(problem.matrix)) {
      report.end = SolveEnd::indefinite;
      solution.clear();
      return report;
    }
    m_factor->solve(problem.right_side, solution);
    report.iterations = 1;
    return report;
  }

  std::size_t memory_bytes() const override { return static_cast<std::size_t>(m_factor->cost().entries * 8.0); }

private:
  std::unique_ptr<SparseFactor> m_factor;
};

} // namespace

Result<std::unique_ptr<LinearMethod>> make_cholesky(const BlockMatrix& matrix) {
  Result<std::unique_ptr<SparseFactor>> factor = SparseFactor::create(matrix);
  if (!factor)
    return std::move(factor).error();
  return std::unique_ptr<LinearMethod>(std::make_unique<Cholesky>(std::move(factor).value()));
}

} // namespace wry::fem
