#include "sim/fem/linear/linear_method.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "sim/fem/linear/block_matrix.h"
#include "tests/fem/solvers_of_this_build.h"

namespace wry::fem {
namespace {

/// Two chains of tets, one with 3 and one with 6 unknowns per node, filled with a definite matrix; long enough that
/// rows fall into several chunks.
struct System {
  static constexpr int NODES = 700;
  DofLayout layout;
  std::vector<std::array<std::int32_t, 4>> tets;
  std::unique_ptr<BlockMatrix> matrix;
  std::vector<double> right_side;

  explicit System(Isa isa, double shift = 30.0) {
    layout.append(NODES, 3);
    layout.append(NODES, 6);
    for (int first : {0, NODES}) {
      for (int i = 0; i + 12 < NODES; ++i)
        tets.push_back({first + i, first + i + 1, first + i + 5, first + i + 12});
    }
    matrix = std::make_unique<BlockMatrix>(layout, tets, isa);
    double wave = 0.0;
    for (BlockMatrix::Section& section : matrix->sections()) {
      const int d = section.nodes.dofs;
      for (int row = 0; row < section.nodes.node_count; ++row) {
        for (std::int64_t k = section.row_begin[row]; k < section.row_begin[row + 1]; ++k) {
          double* block = section.values.data() + k * d * d;
          for (int i = 0; i < d; ++i) {
            for (int j = 0; j < d; ++j)
              block[i * d + j] =
                  section.column[k] == row ? (i == j ? shift + i : 0.1 * (i + j)) : std::sin(wave += 0.7);
          }
        }
      }
    }
    matrix->update_single(Threads(1));
    for (std::size_t i = 0; i < layout.dof_count(); ++i)
      right_side.push_back(std::cos(0.3 * static_cast<double>(i)));
  }

  /// Contacts: within a section, across sections, inside the pattern, twice the same, and the wrong way round.
  void add_pairs() {
    constexpr int PLACES[][2] = {{3, 650}, {10, NODES + 20}, {NODES + 10, NODES + 600},
                                 {2, 3},   {3, 650},         {NODES + 9, 8}};
    double wave = 0.3;
    for (const auto& [row, column] : PLACES) {
      double block[9];
      for (double& value : block)
        value = std::sin(wave += 0.7);
      matrix->add_velocity_pair(row, column, block);
    }
    matrix->finish_pairs();
    matrix->update_single(Threads(1));
  }

  std::vector<double> times(const std::vector<double>& x, int threads = 1) const {
    AlignedVector<double> in;
    AlignedVector<double> out(layout.padded_count());
    pad(layout, x, in);
    matrix->multiply(in, out, Threads(threads));
    std::vector<double> y;
    unpad(layout, out, y);
    return y;
  }

  Eigen::MatrixXd dense() const {
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(layout.dof_count(), layout.dof_count());
    for (const BlockMatrix::Section& section : matrix->sections()) {
      const int d = section.nodes.dofs;
      for (int row = 0; row < section.nodes.node_count; ++row) {
        for (std::int64_t k = section.row_begin[row]; k < section.row_begin[row + 1]; ++k) {
          for (int i = 0; i < d * d; ++i) {
            const Eigen::Index r = section.nodes.first_dof + row * d + i / d;
            const Eigen::Index c = section.nodes.first_dof + section.column[k] * d + i % d;
            full(r, c) = full(c, r) = section.values[k * d * d + i];
          }
        }
      }
    }
    const BlockMatrix::Pairs& pairs = matrix->pairs();
    for (std::size_t row = 0; row + 1 < pairs.row_begin.size(); ++row) {
      for (std::int64_t k = pairs.row_begin[row]; k < pairs.row_begin[row + 1]; ++k) {
        for (int i = 0; i < 9; ++i)
          full(static_cast<Eigen::Index>(layout.dof(static_cast<int>(row))) + i / 3,
               static_cast<Eigen::Index>(layout.dof(pairs.column[k])) + i % 3) = pairs.values[9 * k + i];
      }
    }
    return full;
  }
};

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

TEST(BlockMatrix, MultipliesLikeADenseMatrixOnEveryInstructionSet) {
  for (const Isa isa : {Isa::sse4, Isa::avx2, Isa::avx512}) {
    if (isa > native_isa())
      continue;
    System system(isa);
    for (const bool with_pairs : {false, true}) {
      if (with_pairs)
        system.add_pairs();
      EXPECT_EQ(system.matrix->has_pairs(), with_pairs);
      const Eigen::MatrixXd dense = system.dense();
      EXPECT_EQ((dense - dense.transpose()).norm(), 0.0);
      const Eigen::VectorXd expected =
          dense * Eigen::Map<const Eigen::VectorXd>(system.right_side.data(), system.right_side.size());
      const std::vector<double> product = system.times(system.right_side);
      EXPECT_LT((Eigen::Map<const Eigen::VectorXd>(product.data(), product.size()) - expected).cwiseAbs().maxCoeff(),
                1e-11);
      EXPECT_EQ(difference(system.times(system.right_side, 3), product), 0.0);
    }
  }
}

TEST(BlockMatrix, HoldsUnknownsAsIdentityRows) {
  System system(native_isa());
  std::vector<char> held(system.layout.dof_count(), 0);
  held[17] = held[system.layout.dof(System::NODES + 4) + 5] = 1;
  system.matrix->hold(held, Threads(1));
  std::vector<double> x = system.right_side;
  const std::vector<double> before = system.times(x);
  EXPECT_EQ(before[17], x[17]);
  x[17] += 100.0;
  const std::vector<double> after = system.times(x);
  for (std::size_t i = 0; i < x.size(); ++i)
    EXPECT_EQ(after[i] == before[i], i != 17) << i;
}

Result<std::unique_ptr<LinearMethod>> make_method(LinearSolver solver, const System& system, const Threads& threads) {
  if (solver == LinearSolver::pcg)
    return make_block_jacobi_pcg(*system.matrix, threads);
  return solver == LinearSolver::cholesky ? make_cholesky(*system.matrix)
                                          : make_stale_cholesky(*system.matrix, threads);
}

class EveryLinearMethod : public ::testing::TestWithParam<LinearSolver> {
protected:
  Threads m_threads{1};
  std::vector<Mat3> m_rotations = std::vector<Mat3>(2 * System::NODES, Mat3::Identity());
  std::function<const std::vector<Mat3>&()> m_rotate = [this]() -> const std::vector<Mat3>& { return m_rotations; };
};

TEST_P(EveryLinearMethod, ReachesTheTolerance) {
  System system(native_isa());
  Result<std::unique_ptr<LinearMethod>> method = make_method(GetParam(), system, m_threads);
  ASSERT_TRUE(method) << method.error().message;
  for (const double tolerance : {1e-2, 1e-4, 1e-11}) {
    std::vector<double> solution;
    const SolveReport report = (*method)->solve({*system.matrix, system.right_side, tolerance, m_rotate}, solution);
    ASSERT_EQ(report.end, SolveEnd::solved);
    const std::vector<double> product = system.times(solution);
    EXPECT_LT(difference(product, system.right_side), 30.0 * tolerance);
  }
  system.add_pairs();
  for (const double tolerance : {1e-2, 1e-4, 1e-11}) {
    std::vector<double> solution;
    const SolveReport report = (*method)->solve({*system.matrix, system.right_side, tolerance, m_rotate}, solution);
    ASSERT_EQ(report.end, SolveEnd::solved);
    const std::vector<double> product = system.times(solution);
    EXPECT_LT(difference(product, system.right_side), 30.0 * tolerance);
  }
}

TEST_P(EveryLinearMethod, NoticesThatAMatrixIsIndefinite) {
  const System system(native_isa(), 0.5);
  Result<std::unique_ptr<LinearMethod>> method = make_method(GetParam(), system, m_threads);
  std::vector<double> solution;
  EXPECT_EQ((*method)->solve({*system.matrix, system.right_side, 1e-8, m_rotate}, solution).end, SolveEnd::indefinite);
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryLinearMethod, ::testing::ValuesIn(solvers_of_this_build()));

TEST(PcgOrFactor, HandsOverWhatTakesTooLongAndGoesOnWithTheSameBits) {
  const Threads threads(1);
  System system(native_isa());
  const std::vector<LinearSolver> solvers = solvers_of_this_build();
  const bool has_factor = std::find(solvers.begin(), solvers.end(), LinearSolver::stale_cholesky) != solvers.end();
  const std::vector<Mat3> turns(2 * System::NODES, Mat3::Identity());
  const std::function<const std::vector<Mat3>&()> rotations = [&]() -> const std::vector<Mat3>& { return turns; };
  const auto solve = [&](LinearMethod& method, std::vector<double>& x) {
    return method.solve({*system.matrix, system.right_side, 1e-9, rotations}, x);
  };
  std::vector<double> by_pcg, x, again;
  const int needed = solve(*make_block_jacobi_pcg(*system.matrix, threads), by_pcg).iterations;
  const std::unique_ptr<LinearMethod> patient = make_pcg_or_factor(*system.matrix, threads, 2 * needed);
  EXPECT_EQ(solve(*patient, x).end, SolveEnd::solved);
  EXPECT_EQ(x, by_pcg) << "what iterations can do is left to them";
  EXPECT_EQ(patient->memory_bytes(), 0u);
  const std::unique_ptr<LinearMethod> hasty = make_pcg_or_factor(*system.matrix, threads, 3);
  const SolveReport first = solve(*hasty, x);
  EXPECT_EQ(first.end, has_factor ? SolveEnd::solved : SolveEnd::unfinished);
  if (!has_factor)
    return;
  EXPECT_LT(difference(system.times(x), system.right_side), 1e-8);
  EXPECT_EQ(first.iterations, 3 + 1);
  StateArchive archive;
  hasty->save(archive);
  const std::unique_ptr<LinearMethod> resumed = make_pcg_or_factor(*system.matrix, threads, 3);
  ASSERT_TRUE(resumed->restore(archive));
  for (int i = 0; i < 3; ++i) {
    system.matrix->sections()[0].values[0] += 2.0;
    EXPECT_EQ(solve(*hasty, x).iterations, solve(*resumed, again).iterations);
    EXPECT_EQ(x, again) << "the hand-over outlives a checkpoint";
  }
}

TEST(BlockJacobiPcg, GoesOnDownhillAlongNegativeCurvature) {
  System system(native_isa());
  // One node's block, and two unknowns of another, turned round.
  BlockMatrix::Section& section = system.matrix->sections()[1];
  for (const int node : {40, 300}) {
    double* block = section.values.data() + section.row_begin[node] * 36;
    for (int i = 0; i < (node == 40 ? 6 : 2); ++i)
      block[7 * i] = -20.0;
  }
  system.matrix->update_single(Threads(1));
  const Threads threads(1);
  const std::unique_ptr<LinearMethod> method = make_block_jacobi_pcg(*system.matrix, threads);
  const std::vector<Mat3> turns(2 * System::NODES, Mat3::Identity());
  const std::function<const std::vector<Mat3>&()> rotations = [&]() -> const std::vector<Mat3>& { return turns; };
  std::vector<double> x;
  const SolveReport report = method->solve({*system.matrix, system.right_side, 1e-8, rotations}, x);
  EXPECT_EQ(report.end, SolveEnd::indefinite);
  ASSERT_EQ(x.size(), system.right_side.size());
  const std::vector<double> Ax = system.times(x);
  double slope = 0.0;
  double curvature = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    slope -= system.right_side[i] * x[i];
    curvature += x[i] * Ax[i];
  }
  EXPECT_LT(slope, 0.0);
  EXPECT_LT(slope + 0.5 * curvature, 0.0);
}

} // namespace
} // namespace wry::fem
