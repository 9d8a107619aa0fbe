#include "sim/mpm/matter/stretch.h"

#include <cmath>

#include "sim/base/rotation.h"

namespace wry::mpm {

namespace {

constexpr int MOST_SWEEPS = 30;

/// Cosine and sine of the rotation that makes a symmetric 2 x 2 with diagonal p, q and off-diagonal r diagonal.
struct Givens {
  double c, s;
};
Givens diagonalise(double p, double q, double r) {
  const double zeta = (q - p) / (2.0 * r);
  const double t = (zeta >= 0.0 ? 1.0 : -1.0) / (std::abs(zeta) + std::sqrt(1.0 + zeta * zeta));
  const double c = 1.0 / std::sqrt(1.0 + t * t);
  return {c, t * c};
}

} // namespace

SymmetricEigen symmetric_eigen(const Mat3& S) {
  Mat3 A = 0.5 * (S + S.transpose());
  Mat3 N = Mat3::Identity();
  for (int sweep = 0; sweep < MOST_SWEEPS; ++sweep) {
    const double off = std::abs(A(0, 1)) + std::abs(A(0, 2)) + std::abs(A(1, 2));
    if (off <= 1e-300 || off <= 1e-18 * A.diagonal().cwiseAbs().sum())
      break;
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        if (A(p, q) == 0.0)
          continue;
        const Givens g = diagonalise(A(p, p), A(q, q), A(p, q));
        Mat3 G = Mat3::Identity();
        G(p, p) = G(q, q) = g.c;
        G(p, q) = g.s;
        G(q, p) = -g.s;
        const Mat3 turned = G.transpose() * A * G;
        A = turned;
        A(p, q) = A(q, p) = 0.0;
        const Mat3 vectors = N * G;
        N = vectors;
      }
    }
  }
  return {A.diagonal(), N};
}

LeftPolar left_polar(const Mat3& F) {
  const SymmetricEigen eigen = symmetric_eigen(F * F.transpose());
  Mat3 U = eigen.vectors;
  Mat3 rows = U.transpose() * F;
  for (int sweep = 0; sweep < MOST_SWEEPS; ++sweep) {
    double worst = 0.0;
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        const double a = rows.row(p).squaredNorm(), b = rows.row(q).squaredNorm(), r = rows.row(p).dot(rows.row(q));
        const double relative = std::abs(r) / std::sqrt(a * b);
        worst = std::max(worst, relative);
        if (!(relative > 1e-17))
          continue;
        const Givens g = diagonalise(a, b, r);
        const Eigen::RowVector3d row_p = g.c * rows.row(p) - g.s * rows.row(q);
        const Eigen::RowVector3d row_q = g.s * rows.row(p) + g.c * rows.row(q);
        rows.row(p) = row_p;
        rows.row(q) = row_q;
        const Vec3 column_p = g.c * U.col(p) - g.s * U.col(q);
        const Vec3 column_q = g.s * U.col(p) + g.c * U.col(q);
        U.col(p) = column_p;
        U.col(q) = column_q;
      }
    }
    if (worst < 1e-16)
      break;
  }
  LeftPolar polar;
  polar.stretches = rows.rowwise().norm();
  polar.axes = U;
  const Vec3 inverse = polar.stretches.cwiseInverse();
  const Mat3 unit_rows = inverse.asDiagonal() * rows;
  polar.rotation = U * unit_rows;
  return polar;
}

} // namespace wry::mpm
