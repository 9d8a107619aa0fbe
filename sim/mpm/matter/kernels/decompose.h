#pragma once

#include "sim/mpm/matter/kernels/lanes.h"

/// Decompositions and functions of matrices across lanes. What is computed for a lane never depends on its neighbours:
/// lanes that have converged are left alone while others go on.
namespace wry::mpm::WRY_ISA {

/// Tangent, cosine and sine of the rotation that annihilates r between diagonal entries that differ by d = b - a.
template <class P> struct Givens { P t, c, s; };
template <class P> WRY_INLINE Givens<P> givens(P d, P r, MaskOf<P> skip) {
  using T = ScalarOf<P>;
  const P twice = r + r;
  const P size = magnitude(d) + root(d * d + twice * twice);
  const P slope = (d < 0 ? -twice : twice) / (size == 0 ? all_lanes<P>(1.0) : size);
  const P t = skip ? P{} : slope;
  const P c = static_cast<T>(1) / root(t * t + static_cast<T>(1));
  return {t, c, t * c};
}

/// F = axes diag(stretches) unit_rows: axes are columns of U.
template <class P> struct LeftSvd {
  Mat<P> axes;
  Vec<P> stretches;
  Mat<P> unit_rows;
};

template <class P> WRY_INLINE bool orthogonalise(Vec<P>& p, Vec<P>& q, Vec<P>& u_p, Vec<P>& u_q) {
  const P a = dot(p, p), b = dot(q, q), r = dot(p, q);
  constexpr ScalarOf<P> EPSILON = LaneTraits<P>::EPSILON;
  const MaskOf<P> skip = !(r * r > EPSILON * EPSILON * (a * b));
  const Givens<P> g = givens(b - a, r, skip);
  const Vec<P> p_next = g.c * p - g.s * q, u_next = g.c * u_p - g.s * u_q;
  q = g.s * p + g.c * q;
  u_q = g.s * u_p + g.c * u_q;
  p = p_next;
  u_p = u_next;
  return any_lane(!skip);
}

/// One-sided Jacobi on the rows of F: as exact at a stretch of 1e-6 as at 1.
template <class P> WRY_INLINE LeftSvd<P> left_svd(const Mat<P>& F) {
  const P one = all_lanes<P>(1.0), zero = P{};
  Mat<P> rows = F;
  Mat<P> U = {{one, zero, zero}, {zero, one, zero}, {zero, zero, one}}; // its rows are the axes
  for (int sweep = 0; sweep < 12; ++sweep) {
    bool moved = orthogonalise(rows.r0, rows.r1, U.r0, U.r1);
    moved |= orthogonalise(rows.r0, rows.r2, U.r0, U.r2);
    moved |= orthogonalise(rows.r1, rows.r2, U.r1, U.r2);
    if (!moved)
      break;
  }
  LeftSvd<P> svd;
  svd.axes = transposed(U);
  svd.stretches = {root(dot(rows.r0, rows.r0)), root(dot(rows.r1, rows.r1)), root(dot(rows.r2, rows.r2))};
  svd.unit_rows = {(one / svd.stretches.x) * rows.r0, (one / svd.stretches.y) * rows.r1,
                   (one / svd.stretches.z) * rows.r2};
  return svd;
}

template <class P> struct Eigen3 {
  Vec<P> values;
  Mat<P> axes; ///< columns
};

/// Annihilates the off-diagonal r between the diagonals a and b where it is not skipped; p and q are the entries to the
/// third axis, n_p and n_q the axes so far. Returns whether any lane moved.
template <class P>
WRY_INLINE bool annihilate(P& a, P& b, P& r, P& p, P& q, Vec<P>& n_p, Vec<P>& n_q, const MaskOf<P>& skip) {
  const Givens<P> g = givens(b - a, r, skip);
  a = a - g.t * r;
  b = b + g.t * r;
  r = skip ? r : P{};
  const P p_next = g.c * p - g.s * q;
  q = g.s * p + g.c * q;
  p = p_next;
  const Vec<P> n_next = g.c * n_p - g.s * n_q;
  n_q = g.s * n_p + g.c * n_q;
  n_p = n_next;
  return any_lane(!skip);
}

/// Cyclic Jacobi.
template <class P> WRY_INLINE Eigen3<P> symmetric_eigen(Sym<P> s) {
  const P one = all_lanes<P>(1.0), zero = P{};
  Mat<P> N = {{one, zero, zero}, {zero, one, zero}, {zero, zero, one}}; // its rows are the axes
  constexpr ScalarOf<P> EPSILON = LaneTraits<P>::EPSILON / 4;
  const P least = EPSILON * (magnitude(s.xx) + magnitude(s.yy) + magnitude(s.zz) + magnitude(s.yz) + magnitude(s.zx) +
                             magnitude(s.xy));
  const auto is_small = [&](const P& entry) { return MaskOf<P>(!(magnitude(entry) > least)); };
  for (int sweep = 0; sweep < 12; ++sweep) {
    bool moved = annihilate(s.xx, s.yy, s.xy, s.zx, s.yz, N.r0, N.r1, is_small(s.xy));
    moved |= annihilate(s.xx, s.zz, s.zx, s.xy, s.yz, N.r0, N.r2, is_small(s.zx));
    moved |= annihilate(s.yy, s.zz, s.yz, s.xy, s.zx, N.r1, N.r2, is_small(s.yz));
    if (!moved)
      break;
  }
  return {{s.xx, s.yy, s.zz}, transposed(N)};
}

/// ln V = (1/2) ln(F F^T) of stretches that are alike: artanh of (B - m)(B + m)^-1 with m = tr B / 3, its powers by
/// Cayley and Hamilton. Good to the last digits while the deviator of the result is below SERIES_LIMIT.
inline constexpr double SERIES_LIMIT = 0.25;

template <class P> WRY_INLINE Sym<P> log_stretch_series(const Mat<P>& F) {
  using T = ScalarOf<P>;
  const Sym<P> B = gram(F);
  const P mean = trace(B) * static_cast<T>(1.0 / 3.0);
  const P inverse_mean = static_cast<T>(1) / mean;
  const Sym<P> X = plus_identity(inverse_mean * B, all_lanes<P>(-1.0));
  const Sym<P> Y = plus_identity(X, all_lanes<P>(2.0));
  const Sym<P> adjugate_Y = adjugate(Y);
  const P det_Y = Y.xx * adjugate_Y.xx + Y.xy * adjugate_Y.xy + Y.zx * adjugate_Y.zx;
  const Sym<P> Z = (static_cast<T>(1) / det_Y) * coaxial_product(X, adjugate_Y);
  const Sym<P> S = coaxial_product(Z, Z);
  const Sym<P> S2 = coaxial_product(S, S);
  const P i1 = trace(S), i2 = static_cast<T>(0.5) * (i1 * i1 - trace(S2)), i3 = determinant(S);
  constexpr int TERMS = sizeof(T) == 4 ? 4 : 10;
  P a = all_lanes<P>(1.0 / (2 * TERMS + 1)), b = P{}, c = P{};
  for (int k = TERMS - 1; k >= 0; --k) { // p <- 1/(2k+1) + S p
    const P a_next = c * i3 + static_cast<T>(1.0 / (2 * k + 1));
    const P b_next = a - c * i2;
    c = b + c * i1;
    a = a_next;
    b = b_next;
  }
  const Sym<P> series = coaxial_product(Z, plus_identity(b * S + c * S2, a));
  return plus_identity(series, static_cast<T>(0.5) * logarithm(mean));
}

/// e^S of a symmetric S whose deviator is below SERIES_LIMIT.
template <class P> WRY_INLINE Sym<P> exponential_series(const Sym<P>& S) {
  using T = ScalarOf<P>;
  const P mean = trace(S) * static_cast<T>(1.0 / 3.0);
  const Sym<P> D = plus_identity(S, -mean);
  const Sym<P> D2 = coaxial_product(D, D);
  const P j2 = static_cast<T>(0.5) * trace(D2), j3 = determinant(D); // D^3 = j2 D + j3
  constexpr int TERMS = sizeof(T) == 4 ? 7 : 13;
  P a = all_lanes<P>(1.0), b = P{}, c = P{};
  for (int k = TERMS; k > 0; --k) { // p <- 1 + D p / k
    constexpr T ONE = 1;
    const P s = all_lanes<P>(1.0 / k);
    const P a_next = s * c * j3 + ONE;
    const P b_next = s * (a + c * j2);
    c = s * b;
    a = a_next;
    b = b_next;
  }
  const Sym<P> dev = plus_identity(b * D + c * D2, a);
  return exponential(mean) * dev;
}

/// The rotation nearest to a matrix near a rotation: Newton's R <- (R + R^-T) / 2.
template <class P> WRY_INLINE Mat<P> nearest_rotation(Mat<P> R) {
  constexpr int ITERATIONS = sizeof(ScalarOf<P>) == 4 ? 5 : 6;
  const P half = all_lanes<P>(0.5);
  for (int i = 0; i < ITERATIONS; ++i) {
    const Vec<P> c0 = cross(R.r1, R.r2), c1 = cross(R.r2, R.r0), c2 = cross(R.r0, R.r1);
    const P s = half / dot(R.r0, c0);
    R = {half * R.r0 + s * c0, half * R.r1 + s * c1, half * R.r2 + s * c2};
  }
  return R;
}

} // namespace wry::mpm::WRY_ISA
