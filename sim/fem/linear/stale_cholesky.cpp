#include <algorithm>

#include "sim/fem/linear/conjugate_gradients.h"
#include "sim/fem/linear/solver_cost.h"
#include "sim/fem/linear/sparse_factor.h"

namespace wry::fem {

namespace {

/// z = Q A0^-1 Q^T r, with A0 the factored matrix and Q how far each node has turned since.
class TurnedFactor final : public Preconditioner<double> {
public:
  TurnedFactor(SparseFactor& factor, const DofLayout& layout)
      : m_factor(factor)
      , m_layout(layout) {}

  /// Rotation of each node since the factor was made.
  std::vector<Mat3> turns;

  double apply(const AlignedVector<double>& r, AlignedVector<double>& z) const override {
    m_turned.resize(m_layout.dof_count());
    for_each_vector([&](int node, std::size_t packed, std::size_t padded) {
      Eigen::Map<Vec3>(m_turned.data() + packed).noalias() =
          turns[node].transpose() * Eigen::Map<const Vec3>(r.data() + padded);
    });
    m_factor.solve(m_turned, m_solved);
    double dot = 0.0;
    for_each_vector([&](int node, std::size_t packed, std::size_t padded) {
      const Vec3 result = turns[node] * Eigen::Map<const Vec3>(m_solved.data() + packed);
      Eigen::Map<Vec3>(z.data() + padded) = result;
      dot += result.dot(Eigen::Map<const Vec3>(r.data() + padded));
    });
    return dot;
  }

private:
  template <class Body> void for_each_vector(const Body& body) const {
    for (const NodeSection& section : m_layout.sections()) {
      for (int node = 0; node < section.node_count; ++node) {
        for (int i = 0; i < section.dofs; i += 3)
          body(section.first_node + node, section.first_dof + static_cast<std::size_t>(node) * section.dofs + i,
               section.first_padded + static_cast<std::size_t>(node) * section.stride() + i);
      }
    }
  }

  SparseFactor& m_factor;
  const DofLayout& m_layout;
  mutable std::vector<double> m_turned, m_solved;
};

class StaleCholesky final : public LinearMethod {
public:
  StaleCholesky(std::unique_ptr<SparseFactor> factor, const BlockMatrix& matrix, const Threads& threads)
      : m_factor(std::move(factor))
      , m_preconditioner(*m_factor, matrix.layout())
      , m_matrix(matrix)
      , m_threads(threads) {
    const double per_iteration = iteration_seconds(m_factor->cost(), matrix.entry_count());
    m_iterations_per_factor = std::max(4, static_cast<int>(factor_seconds(m_factor->cost()) / per_iteration));
  }

  SolveReport solve(const LinearProblem& problem, std::vector<double>& solution) override {
    SolveReport report;
    const std::vector<Mat3>& rotations = problem.node_rotations();
    if (m_factored && !m_renew) {
      turn(rotations);
      report = conjugate_gradients<double>(problem.matrix, m_preconditioner, problem.right_side, problem.tolerance,
                                           2 * m_iterations_per_factor, m_work, m_threads, solution);
      m_renew = report.iterations > m_iterations_per_factor;
      if (report.end != SolveEnd::unfinished)
        return report;
    }
    const int spent = report.iterations;
    report = solve_anew(problem, rotations, solution);
    report.iterations += spent;
    return report;
  }

  std::size_t saved_bytes() const override {
    std::size_t values = static_cast<std::size_t>(m_matrix.layout().node_count()) * 9;
    for (const BlockMatrix::Section& section : m_matrix.sections())
      values += section.values.size();
    return values * sizeof(double);
  }

  void save(StateArchive& archive) const override {
    archive.push_back({"fem/stale/flags", {2}, {m_factored ? 1.0 : 0.0, m_renew ? 1.0 : 0.0}});
    if (!m_factored)
      return;
    NamedArray rotations{"fem/stale/rotations", {m_rotations.size(), 9}, {}};
    for (const Mat3& rotation : m_rotations)
      rotations.values.insert(rotations.values.end(), rotation.data(), rotation.data() + 9);
    archive.push_back(std::move(rotations));
    for (std::size_t i = 0; i < m_values.size(); ++i)
      archive.push_back({"fem/stale/matrix" + std::to_string(i),
                         {m_values[i].size()},
                         std::vector<double>(m_values[i].begin(), m_values[i].end())});
    archive.push_back({"fem/stale/pair_rows",
                       {m_pairs.row_begin.size()},
                       std::vector<double>(m_pairs.row_begin.begin(), m_pairs.row_begin.end())});
    archive.push_back({"fem/stale/pair_columns",
                       {m_pairs.column.size()},
                       std::vector<double>(m_pairs.column.begin(), m_pairs.column.end())});
    archive.push_back({"fem/stale/pair_values", {m_pairs.values.size()}, m_pairs.values});
  }

  Status restore(const StateArchive& archive) override {
    m_factored = m_renew = false;
    BlockMatrix copy = m_matrix;
    BlockMatrix::Pairs pairs;
    std::size_t matrices = 0;
    for (const NamedArray& array : archive) {
      if (array.name == "fem/stale/flags" && array.values.size() == 2) {
        m_factored = array.values[0] != 0.0;
        m_renew = array.values[1] != 0.0;
      } else if (array.name == "fem/stale/rotations") {
        m_rotations.clear();
        for (std::size_t i = 0; i + 9 <= array.values.size(); i += 9)
          m_rotations.push_back(Eigen::Map<const Mat3>(array.values.data() + i));
      } else if (array.name == "fem/stale/pair_rows") {
        pairs.row_begin.assign(array.values.begin(), array.values.end());
      } else if (array.name == "fem/stale/pair_columns") {
        pairs.column.assign(array.values.begin(), array.values.end());
      } else if (array.name == "fem/stale/pair_values") {
        pairs.values = array.values;
      } else if (array.name.starts_with("fem/stale/matrix")) {
        if (matrices >= copy.sections().size() || array.values.size() != copy.sections()[matrices].values.size())
          return make_error(ErrorCode::io, "checkpoint: {} has {} entries, which do not fit this shot", array.name,
                            array.values.size());
        std::copy(array.values.begin(), array.values.end(), copy.sections()[matrices++].values.begin());
      }
    }
    if (!m_factored)
      return {};
    const std::size_t nodes = static_cast<std::size_t>(m_matrix.layout().node_count());
    if (pairs.values.size() != 9 * pairs.column.size() ||
        (!pairs.column.empty() && pairs.row_begin.size() != nodes + 1))
      return make_error(ErrorCode::io, "checkpoint: the contacts of the stored preconditioner do not fit this shot");
    copy.set_pairs(std::move(pairs));
    if (matrices != copy.sections().size() || m_rotations.size() != nodes || !m_factor->factor(copy))
      return make_error(ErrorCode::io,
                        "checkpoint: the stored preconditioner is incomplete ({} of {} matrices, {} of {} "
                        "rotations)",
                        matrices, copy.sections().size(), m_rotations.size(), nodes);
    remember(copy);
    return {};
  }

  std::size_t memory_bytes() const override {
    return static_cast<std::size_t>((m_factor->cost().entries + 2.0 * m_matrix.entry_count()) * 8.0);
  }

private:
  void turn(const std::vector<Mat3>& rotations) {
    m_preconditioner.turns.resize(rotations.size());
    for (std::size_t node = 0; node < rotations.size(); ++node)
      m_preconditioner.turns[node].noalias() = rotations[node] * m_rotations[node].transpose();
  }

  void remember(const BlockMatrix& matrix) {
    m_values.clear();
    for (const BlockMatrix::Section& section : matrix.sections())
      m_values.push_back(section.values);
    m_pairs = matrix.pairs();
  }

  SolveReport solve_anew(const LinearProblem& problem, const std::vector<Mat3>& rotations,
                         std::vector<double>& solution) {
    SolveReport report;
    m_factored = m_factor->factor(problem.matrix);
    m_renew = false;
    if (!m_factored) {
      report.end = SolveEnd::indefinite;
      solution.clear();
      return report;
    }
    m_rotations = rotations;
    remember(problem.matrix);
    m_factor->solve(problem.right_side, solution);
    report.iterations = 1;
    return report;
  }

  std::unique_ptr<SparseFactor> m_factor;
  TurnedFactor m_preconditioner;
  const BlockMatrix& m_matrix;
  const Threads& m_threads;
  ConjugateGradientVectors<double> m_work;
  std::vector<AlignedVector<double>> m_values; ///< of the factored matrix
  BlockMatrix::Pairs m_pairs;                  ///< of the factored matrix
  std::vector<Mat3> m_rotations;               ///< of the nodes when it was factored
  int m_iterations_per_factor = 4;             ///< what a factor is worth, in iterations
  bool m_factored = false;
  bool m_renew = false;
};

} // namespace

Result<std::unique_ptr<LinearMethod>> make_stale_cholesky(const BlockMatrix& matrix, const Threads& threads) {
  Result<std::unique_ptr<SparseFactor>> factor = SparseFactor::create(matrix);
  if (!factor)
    return std::move(factor).error();
  return std::unique_ptr<LinearMethod>(std::make_unique<StaleCholesky>(std::move(factor).value(), matrix, threads));
}

} // namespace wry::fem
