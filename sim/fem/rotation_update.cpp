#include "sim/fem/rotation_update.h"

#include <cmath>

namespace wry::fem {

namespace {

/// a(r) = f r with f = 2 tan(t/2) / t, t = |r|; its derivatives divided by t: h = f'/t and k = h'/t.
struct Factors {
  double f, h, k;
};

Factors factors_of(const Vec3& r) {
  const double square = r.squaredNorm();
  if (square < 1e-2) { // the terms left out are below 1e-13 of the first
    const double q = square;
    return {1.0 + q / 12.0 + q * q / 120.0 + 17.0 * q * q * q / 20160.0 + 31.0 * q * q * q * q / 362880.0 +
                691.0 * q * q * q * q * q / 79833600.0,
            1.0 / 6.0 + q / 30.0 + 17.0 * q * q / 3360.0 + 31.0 * q * q * q / 45360.0 +
                691.0 * q * q * q * q / 7983360.0,
            1.0 / 15.0 + 17.0 * q / 840.0 + 31.0 * q * q / 7560.0 + 691.0 * q * q * q / 997920.0};
  }
  const double angle = std::sqrt(square);
  const double tangent = std::tan(0.5 * angle);
  const double secant = 1.0 + tangent * tangent;
  const double f = 2.0 * tangent / angle;
  const double h = (secant - f) / square;
  return {f, h, (secant * tangent / angle - 3.0 * h) / square};
}

/// The rotation vector of a node at the stage's end.
Vec3 vector_of(const Stage& stage, const Trial& trial, int node) {
  return stage.beta * trial.angular.row(node).transpose();
}

} // namespace

Vec3 cayley_of_rotation_vector(const Vec3& r) {
  return factors_of(r).f * r;
}

Vec3 rotation_vector_of_cayley(const Vec3& a) {
  const double length = a.norm();
  return length == 0.0 ? Vec3(Vec3::Zero()) : Vec3(2.0 * std::atan(0.5 * length) / length * a);
}

Mat3 cayley_slope(const Vec3& r) {
  const Factors factors = factors_of(r);
  return factors.f * Mat3::Identity() + factors.h * (r * r.transpose());
}

Mat3 cayley_curvature(const Vec3& r, const Vec3& g) {
  const Factors factors = factors_of(r);
  const double along = g.dot(r);
  return factors.h * (g * r.transpose() + r * g.transpose() + along * Mat3::Identity()) +
         (factors.k * along) * (r * r.transpose());
}

void chain_gradient(const DofLayout& layout, const Stage& stage, const Trial& trial, std::vector<double>& gradient) {
  for (int node = 0; node < layout.node_count(); ++node) {
    if (layout.dofs(node) != 6)
      continue;
    Eigen::Map<Vec3> g(gradient.data() + layout.dof(node) + 3);
    g = cayley_slope(vector_of(stage, trial, node)) * Vec3(g);
  }
}

void chain_hessian(const Stage& stage, const Trial& trial, const std::vector<double>& gradient, BlockMatrix& matrix) {
  using Block = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
  for (BlockMatrix::Section& section : matrix.sections()) {
    if (section.nodes.dofs != 6)
      continue;
    const int first = section.nodes.first_node;
    for (int row = 0; row < section.nodes.node_count; ++row) {
      const Mat3 T_row = cayley_slope(vector_of(stage, trial, first + row));
      for (std::int64_t k = section.row_begin[row]; k < section.row_begin[row + 1]; ++k) {
        const int column = section.column[k];
        Eigen::Map<Block> block(section.values.data() + k * 36);
        const Mat3 T_column = cayley_slope(vector_of(stage, trial, first + column));
        block.bottomRows<3>() = T_row * Eigen::Matrix<double, 3, 6>(block.bottomRows<3>());
        block.rightCols<3>() = Eigen::Matrix<double, 6, 3>(block.rightCols<3>()) * T_column;
        if (column != row)
          continue;
        const Vec3 g = Eigen::Map<const Vec3>(gradient.data() + matrix.layout().dof(first + row) + 3);
        block.bottomRightCorner<3, 3>() += stage.beta * cayley_curvature(vector_of(stage, trial, first + row), g);
      }
    }
  }
}

} // namespace wry::fem
