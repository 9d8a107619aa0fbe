#include "sim/fem/element_projection.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace wry::fem {

namespace {

/// Share of the largest diagonal entry that passes for round-off: rigid motions have eigenvalue zero.
constexpr double ROUND_OFF = 1e-9;

template <int D, class Body> void for_each_entry(const Body& body) {
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

} // namespace

template <int D> bool project_element(double* hessian, int lane, const std::array<double, 4>& inertia) {
  using Matrix = Eigen::Matrix<double, 4 * D, 4 * D>;
  Matrix element;
  for_each_entry<D>([&](int entry, int row, int column) {
    element(row, column) = element(column, row) = hessian[entry * LANES + lane];
  });
  for (int k = 0; k < 4; ++k)
    element.diagonal().template segment<3>(k * D).array() += inertia[static_cast<std::size_t>(k)];
  const double scale = element.diagonal().cwiseAbs().maxCoeff();
  Matrix shifted = element;
  shifted.diagonal().array() += ROUND_OFF * scale;
  if (Eigen::LLT<Matrix>(shifted).info() == Eigen::Success)
    return false;
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(element);
  Matrix clamped =
      eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
  for (int k = 0; k < 4; ++k)
    clamped.diagonal().template segment<3>(k * D).array() -= inertia[static_cast<std::size_t>(k)];
  for_each_entry<D>([&](int entry, int row, int column) { hessian[entry * LANES + lane] = clamped(row, column); });
  return true;
}

template bool project_element<3>(double*, int, const std::array<double, 4>&);
template bool project_element<6>(double*, int, const std::array<double, 4>&);

} // namespace wry::fem
