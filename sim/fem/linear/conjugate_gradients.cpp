#include "sim/fem/linear/conjugate_gradients.h"

#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace wry::fem {

namespace {

constexpr std::size_t NODE_GRAIN = 512;
constexpr std::size_t ENTRY_GRAIN = 16384;
/// About as many entries as NODE_GRAIN nodes have: each thread turns those entries that it has just updated.
constexpr std::size_t TURN_GRAIN = 4 * NODE_GRAIN;
/// How far a direction of negative curvature is followed, in lengths of the solution so far.
constexpr double LONGEST_OVER_RIDGE = 3.0;

template <class Scalar, int D, int STRIDE> bool invert_block(const double* block, Scalar* inverse) {
  using Block = Eigen::Matrix<double, D, D, Eigen::RowMajor>;
  const Eigen::Map<const Block> values(block);
  if (!values.allFinite())
    return false;
  Block result;
  if (const Eigen::LLT<Block> factor(values); factor.info() == Eigen::Success) {
    result = factor.solve(Block::Identity());
  } else { // the matrix is indefinite, but what preconditions it must not be
    const Eigen::SelfAdjointEigenSolver<Block> eigen(values);
    const double least = std::numeric_limits<double>::epsilon() * values.norm();
    if (!(least > 0.0))
      return false;
    result = eigen.eigenvectors() * eigen.eigenvalues().cwiseAbs().cwiseMax(least).cwiseInverse().asDiagonal() *
             eigen.eigenvectors().transpose();
  }
  for (int column = 0; column < D; ++column) {
    for (int row = 0; row < STRIDE; ++row)
      inverse[column * STRIDE + row] = row < D ? static_cast<Scalar>(result(row, column)) : Scalar(0);
  }
  return true;
}

template <class Scalar, int D, int STRIDE>
double apply_blocks(const Scalar* inverses, const Scalar* r, Scalar* z, std::size_t begin, std::size_t end) {
  double dot = 0.0;
  for (std::size_t node = begin; node < end; ++node) {
    const Scalar* inverse = inverses + node * (D * STRIDE);
    const Scalar* in = r + node * STRIDE;
    Scalar sum[STRIDE] = {};
    for (int column = 0; column < D; ++column) {
      for (int row = 0; row < STRIDE; ++row)
        sum[row] += inverse[column * STRIDE + row] * in[column];
    }
    Scalar product = 0;
    for (int row = 0; row < STRIDE; ++row) {
      z[node * STRIDE + row] = sum[row];
      product += sum[row] * in[row];
    }
    dot += static_cast<double>(product);
  }
  return dot;
}

template <class Scalar> double squared_norm(const AlignedVector<Scalar>& vector, const Threads& threads) {
  return threads.sum_chunks(vector.size(), ENTRY_GRAIN, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i)
      sum += static_cast<double>(vector[i]) * static_cast<double>(vector[i]);
    return sum;
  });
}

template <class Scalar>
void turn_direction(ConjugateGradientVectors<Scalar>& work, Scalar beta, const Threads& threads) {
  threads.for_chunks(work.x.size(), TURN_GRAIN, [&](std::size_t begin, std::size_t end) {
    const Scalar* z = work.z.data();
    Scalar* p = work.p.data();
    for (std::size_t i = begin; i < end; ++i)
      p[i] = z[i] + beta * p[i];
  });
}

/// Adds to x a way along p, which leads down on both sides of a ridge: as far as if the curvature were positive, but
/// not beyond all that came before.
template <class Scalar>
void follow_negative_curvature(ConjugateGradientVectors<Scalar>& work, double rz, double curvature,
                               const Threads& threads) {
  double step = rz / -curvature;
  const double before = std::sqrt(squared_norm(work.x, threads));
  const double length = step * std::sqrt(squared_norm(work.p, threads));
  if (before > 0.0 && length > LONGEST_OVER_RIDGE * before)
    step *= LONGEST_OVER_RIDGE * before / length;
  for (std::size_t i = 0; i < work.x.size(); ++i)
    work.x[i] += static_cast<Scalar>(step) * work.p[i];
}

} // namespace

template <class Scalar>
ResidualDots Preconditioner<Scalar>::advance(ConjugateGradientVectors<Scalar>& work, Scalar alpha,
                                             const Threads& threads) const {
  threads.for_chunks(work.x.size(), ENTRY_GRAIN, [&](std::size_t begin, std::size_t end) {
    const Scalar* p = work.p.data();
    const Scalar* q = work.q.data();
    Scalar* x = work.x.data();
    Scalar* r = work.r.data();
    for (std::size_t i = begin; i < end; ++i) {
      x[i] += alpha * p[i];
      r[i] -= alpha * q[i];
    }
  });
  return {squared_norm(work.r, threads), apply(work.r, work.z)};
}

template <class Scalar>
ResidualDots BlockJacobi<Scalar>::advance(ConjugateGradientVectors<Scalar>& work, Scalar alpha,
                                          const Threads& threads) const {
  ResidualDots sum;
  for (std::size_t index = 0; index < m_inverses.size(); ++index) {
    const BlockMatrix::Section& section = m_matrix->sections()[index];
    const std::size_t first = section.nodes.first_padded;
    const std::size_t chunks = (section.nodes.node_count + NODE_GRAIN - 1) / NODE_GRAIN;
    std::vector<std::array<double, 2>> dots(chunks);
    threads.for_chunks(section.nodes.node_count, NODE_GRAIN, [&](std::size_t begin, std::size_t end) {
      m_matrix->functions<Scalar>(section).update(static_cast<int>(begin), static_cast<int>(end), alpha,
                                                  m_inverses[index].data(), work.p.data() + first,
                                                  work.q.data() + first, work.x.data() + first, work.r.data() + first,
                                                  work.z.data() + first, dots[begin / NODE_GRAIN].data());
    });
    for (const std::array<double, 2>& partial : dots) {
      sum.squared += partial[0];
      sum.preconditioned += partial[1];
    }
  }
  return sum;
}

template <class Scalar> bool BlockJacobi<Scalar>::update(const BlockMatrix& matrix, const Threads& threads) {
  m_matrix = &matrix;
  m_threads = &threads;
  m_inverses.resize(matrix.sections().size());
  double failures = 0.0;
  for (std::size_t index = 0; index < matrix.sections().size(); ++index) {
    const BlockMatrix::Section& section = matrix.sections()[index];
    const int d = section.nodes.dofs;
    const int stride = section.nodes.stride();
    AlignedVector<Scalar>& inverses = m_inverses[index];
    inverses.resize(static_cast<std::size_t>(section.nodes.node_count) * d * stride);
    failures += threads.sum_chunks(section.nodes.node_count, NODE_GRAIN, [&](std::size_t begin, std::size_t end) {
      double failed = 0.0;
      for (std::size_t node = begin; node < end; ++node) {
        const double* block = section.values.data() + section.row_begin[node] * d * d;
        Scalar* inverse = inverses.data() + node * d * stride;
        const bool ok =
            d == 3 ? invert_block<Scalar, 3, 4>(block, inverse) : invert_block<Scalar, 6, 8>(block, inverse);
        failed += ok ? 0.0 : 1.0;
      }
      return failed;
    });
  }
  return failures == 0.0;
}

template <class Scalar>
double BlockJacobi<Scalar>::apply(const AlignedVector<Scalar>& r, AlignedVector<Scalar>& z) const {
  double dot = 0.0;
  for (std::size_t index = 0; index < m_inverses.size(); ++index) {
    const NodeSection& nodes = m_matrix->sections()[index].nodes;
    const Scalar* inverses = m_inverses[index].data();
    const Scalar* in = r.data() + nodes.first_padded;
    Scalar* out = z.data() + nodes.first_padded;
    dot += m_threads->sum_chunks(nodes.node_count, NODE_GRAIN, [&](std::size_t begin, std::size_t end) {
      return nodes.dofs == 3 ? apply_blocks<Scalar, 3, 4>(inverses, in, out, begin, end)
                             : apply_blocks<Scalar, 6, 8>(inverses, in, out, begin, end);
    });
  }
  return dot;
}

template <class Scalar>
SolveReport conjugate_gradients(const BlockMatrix& matrix, const Preconditioner<Scalar>& preconditioner,
                                const std::vector<double>& right_side, double tolerance, int max_iterations,
                                ConjugateGradientVectors<Scalar>& work, const Threads& threads,
                                std::vector<double>& solution) {
  const DofLayout& layout = matrix.layout();
  const std::size_t size = layout.padded_count();
  pad(layout, right_side, work.r);
  work.x.assign(size, Scalar(0));
  work.z.assign(size, Scalar(0));
  work.q.assign(size, Scalar(0));
  SolveReport report;
  const double norm = std::sqrt(squared_norm(work.r, threads));
  double rz = norm > 0.0 ? preconditioner.apply(work.r, work.z) : 0.0;
  work.p = work.z;
  report.end = norm > 0.0 ? SolveEnd::unfinished : SolveEnd::solved;
  report.relative_residual = norm > 0.0 ? 1.0 : 0.0;
  while (report.end == SolveEnd::unfinished && report.iterations < max_iterations) {
    const double curvature = matrix.multiply(work.p, work.q, threads);
    if (!(rz > 0.0) || !(curvature > 0.0) || !std::isfinite(curvature)) {
      report.end = SolveEnd::indefinite;
      if (rz > 0.0 && curvature < 0.0 && std::isfinite(curvature))
        follow_negative_curvature(work, rz, curvature, threads);
      break;
    }
    ++report.iterations;
    const ResidualDots dots = preconditioner.advance(work, static_cast<Scalar>(rz / curvature), threads);
    report.relative_residual = std::sqrt(dots.squared) / norm;
    if (report.relative_residual <= tolerance) {
      report.end = SolveEnd::solved;
      break;
    }
    turn_direction(work, static_cast<Scalar>(dots.preconditioned / rz), threads);
    rz = dots.preconditioned;
  }
  unpad(layout, work.x, solution);
  return report;
}

template class Preconditioner<float>;
template class Preconditioner<double>;
template class BlockJacobi<float>;
template class BlockJacobi<double>;
template SolveReport conjugate_gradients<float>(const BlockMatrix&, const Preconditioner<float>&,
                                                const std::vector<double>&, double, int,
                                                ConjugateGradientVectors<float>&, const Threads&, std::vector<double>&);
template SolveReport conjugate_gradients<double>(const BlockMatrix&, const Preconditioner<double>&,
                                                 const std::vector<double>&, double, int,
                                                 ConjugateGradientVectors<double>&, const Threads&,
                                                 std::vector<double>&);

} // namespace wry::fem
