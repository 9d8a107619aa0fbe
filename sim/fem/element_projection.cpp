#include "sim/fem/element_projection.h"

#include <algorithm>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "sim/base/types.h"

namespace wry::fem {

namespace {

/// Share of the largest diagonal entry that passes for round-off: rigid motions have eigenvalue zero.
constexpr double ROUND_OFF = 1e-9;

constexpr int D = 6; // unknowns per node

template <class Body> void for_each_entry(const Body& body) {
  int block = 0;
  for (int k = 0; k < 4; ++k) {
    for (int l = k; l < 4; ++l, ++block) {
      for (int i = 0; i < D; ++i) {
        for (int j = 0; j < D; ++j)
          body((block * D + i) * D + j, k * D + i, l * D + j);
      }
    }
  }
}

using Matrix12 = Eigen::Matrix<double, 12, 12>;

bool is_semidefinite(const Matrix12& m) {
  Matrix12 shifted = m;
  shifted.diagonal().array() += ROUND_OFF * m.diagonal().cwiseAbs().maxCoeff();
  return Eigen::LLT<Matrix12>(shifted).info() == Eigen::Success;
}

/// What was found about an element whose unknowns were eliminated one kind after the other.
enum class Elimination { definite, projected, impossible };

/// Eliminates the positions, which with their inertia are nearly always definite, and clamps what is left of the
/// rotations: an eighth of the work of clamping the whole, and no comparison of newtons per metre with newton metres.
Elimination project_rotations(double* hessian, int lane, const std::array<double, 4>& inertia) {
  Matrix12 positions, mixed, rotations; // mixed: rows positions, columns rotations
  for_each_entry([&](int entry, int row, int column) {
    const double value = hessian[entry * LANES + lane];
    const int k = row / 6 * 3 + row % 3;
    const int l = column / 6 * 3 + column % 3;
    const bool from_position = row % 6 < 3;
    const bool to_position = column % 6 < 3;
    if (from_position && to_position)
      positions(k, l) = positions(l, k) = value;
    else if (from_position)
      mixed(k, l) = value;
    else if (to_position)
      mixed(l, k) = value;
    else
      rotations(k, l) = rotations(l, k) = value;
  });
  for (int k = 0; k < 4; ++k)
    positions.diagonal().segment<3>(3 * k).array() += inertia[static_cast<std::size_t>(k)];
  const Eigen::LLT<Matrix12> factor(positions);
  if (factor.info() != Eigen::Success)
    return Elimination::impossible;
  const Matrix12 half = factor.matrixL().solve(mixed);
  const Matrix12 rest = rotations - half.transpose() * half;
  if (is_semidefinite(rest))
    return Elimination::definite;
  const Eigen::SelfAdjointEigenSolver<Matrix12> eigen(rest);
  rotations -= eigen.eigenvectors() * eigen.eigenvalues().cwiseMin(0.0).asDiagonal() * eigen.eigenvectors().transpose();
  for_each_entry([&](int entry, int row, int column) {
    if (row % 6 >= 3 && column % 6 >= 3)
      hessian[entry * LANES + lane] = rotations(row / 6 * 3 + row % 3, column / 6 * 3 + column % 3);
  });
  return Elimination::projected;
}

} // namespace

bool project_element(double* hessian, int lane, const std::array<double, 4>& inertia) {
  using Matrix = Eigen::Matrix<double, 24, 24>;
  if (std::all_of(inertia.begin(), inertia.end(), [](double value) { return value > 0.0; })) {
    const Elimination elimination = project_rotations(hessian, lane, inertia);
    if (elimination != Elimination::impossible)
      return elimination == Elimination::projected;
  }
  Matrix element;
  for_each_entry([&](int entry, int row, int column) {
    element(row, column) = element(column, row) = hessian[entry * LANES + lane];
  });
  for (int k = 0; k < 4; ++k)
    element.diagonal().segment<3>(k * 6).array() += inertia[static_cast<std::size_t>(k)];
  const double scale = element.diagonal().cwiseAbs().maxCoeff();
  Matrix shifted = element;
  shifted.diagonal().array() += ROUND_OFF * scale;
  if (Eigen::LLT<Matrix>(shifted).info() == Eigen::Success)
    return false;
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(element);
  Matrix clamped =
      eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
  for (int k = 0; k < 4; ++k)
    clamped.diagonal().segment<3>(k * 6).array() -= inertia[static_cast<std::size_t>(k)];
  for_each_entry([&](int entry, int row, int column) { hessian[entry * LANES + lane] = clamped(row, column); });
  return true;
}

} // namespace wry::fem
