#pragma once

#include "sim/fem/kernels/tensors.h"

namespace wry::fem::WRY_ISA {

/// One Jacobi rotation that makes entry (p, q) of a symmetric matrix zero; the vectors' columns turn with it.
WRY_INLINE void turn_jacobi(Real (&m)[4][4], Real (&vectors)[4][4], int p, int q) {
  const Real difference = m[q][q] - m[p][p];
  const Real twice = 2.0 * m[p][q];
  const Real root = sqrt(difference * difference + twice * twice) + 1e-300;
  const Real t = difference < 0.0 ? twice / (difference - root) : twice / (difference + root);
  const Real c = 1.0 / sqrt(1.0 + t * t);
  const Real s = t * c;
  for (int i = 0; i < 4; ++i) {
    const Real a = m[i][p], b = m[i][q];
    m[i][p] = c * a - s * b;
    m[i][q] = s * a + c * b;
  }
  for (int i = 0; i < 4; ++i) {
    const Real a = m[p][i], b = m[q][i];
    m[p][i] = c * a - s * b;
    m[q][i] = s * a + c * b;
  }
  for (int i = 0; i < 4; ++i) {
    const Real a = vectors[i][p], b = vectors[i][q];
    vectors[i][p] = c * a - s * b;
    vectors[i][q] = s * a + c * b;
  }
}

/// The rotation nearest to F, det +1 whatever the sign of det F: it maximises tr(R^T F) = q^T K q, so q is the dominant
/// eigenvector of a symmetric 4 x 4 matrix (found by Jacobi's method, which converges from anywhere).
WRY_INLINE Mat nearest_rotation(const Mat& F) {
  const Vec a = axial(F);
  const Real tr = trace(F);
  const Real xy = F.r0.y + F.r1.x, xz = F.r0.z + F.r2.x, yz = F.r1.z + F.r2.y;
  Real m[4][4] = {{tr, a.x, a.y, a.z},
                  {a.x, 2.0 * F.r0.x - tr, xy, xz},
                  {a.y, xy, 2.0 * F.r1.y - tr, yz},
                  {a.z, xz, yz, 2.0 * F.r2.z - tr}};
  Real vectors[4][4] = {};
  for (int i = 0; i < 4; ++i)
    vectors[i][i] = broadcast(1.0);
  constexpr int SWEEPS = 6; // convergence is quadratic: four sweeps reach 1e-8, six leave round-off
  for (int sweep = 0; sweep < SWEEPS; ++sweep) {
    turn_jacobi(m, vectors, 0, 1);
    turn_jacobi(m, vectors, 2, 3);
    turn_jacobi(m, vectors, 0, 2);
    turn_jacobi(m, vectors, 1, 3);
    turn_jacobi(m, vectors, 0, 3);
    turn_jacobi(m, vectors, 1, 2);
  }
  Quat q = {vectors[0][0], vectors[1][0], vectors[2][0], vectors[3][0]};
  Real largest = m[0][0];
  for (int i = 1; i < 4; ++i) {
    const auto better = m[i][i] > largest;
    q = {better ? vectors[0][i] : q.w, better ? vectors[1][i] : q.x, better ? vectors[2][i] : q.y,
         better ? vectors[3][i] : q.z};
    largest = better ? m[i][i] : largest;
  }
  return (1.0 / dot(q, q)) * scaled_rotation(q);
}

} // namespace wry::fem::WRY_ISA
