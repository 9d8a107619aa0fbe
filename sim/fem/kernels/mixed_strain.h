#pragma once

#include "sim/fem/kernels/mixed_shape.h"
#include "sim/fem/kernels/points.h"

/// Stretch of elements with their own functions for positions: each point sees the element as a linear one between
/// `corner` places of its own, which are sums of the nodes' positions. Formulas as in micropolar.h, with V = F R^T,
/// where F of a plate has rank two: |E|^2 = |V - P|^2 and tr E = tr V - 2, P the projection on the turned plane.
namespace wry::fem::WRY_ISA {

struct PointModuli {
  Real mu, lambda, couple; ///< times the weight of the point
};

/// Stretch at one point, and its derivatives by the places of corners 1 .. CORNERS - 1.
template <class Shape> struct PointStretch {
  static constexpr int FREE = Shape::CORNERS - 1;
  Vec edges[FREE];
  Real energy;
  Vec force[FREE];
  Mat blocks[FREE * (FREE + 1) / 2]; ///< k <= l
};

template <class Shape> WRY_INLINE Mat gradient_of(const PointStretch<Shape>& at, const Vec* gradients) {
  Mat F = outer(at.edges[0], gradients[0]);
  for (int k = 1; k < PointStretch<Shape>::FREE; ++k)
    F = F + outer(at.edges[k], gradients[k]);
  return F;
}

/// Adds mu |E|^2 + lambda/2 tr(E)^2 - couple/2 |z|^2 and, up to ORDER, its derivatives by places (at) and turns
/// (point).
template <class Shape, bool COUPLE, Order ORDER>
WRY_INLINE void add_point_strain(const Mat& F, const Vec* gradients, const Vec& normal, const PointModuli& moduli,
                                 Point& point, PointStretch<Shape>& at) {
  constexpr int FREE = PointStretch<Shape>::FREE;
  const Mat V = F * transposed(point.R);
  Mat W = plus_identity(V, broadcast(-1.0));
  if constexpr (Shape::DIM == 2) {
    const Vec n = point.R * normal;
    W = W + outer(n, n);
  }
  const Vec z = axial(V);
  const Real tr = trace(W);
  at.energy += moduli.mu * (dot(W.r0, W.r0) + dot(W.r1, W.r1) + dot(W.r2, W.r2)) + 0.5 * moduli.lambda * tr * tr;
  if constexpr (COUPLE)
    at.energy -= 0.5 * moduli.couple * dot(z, z);
  if constexpr (ORDER == Order::energy)
    return;

  const Sym A = symmetric_part(V);
  const Real trace_A = tr + static_cast<double>(Shape::DIM);
  const Real s = moduli.lambda * tr - 2.0 * moduli.mu;
  Vec b[FREE];
  point.torque = s * z;
  if constexpr (COUPLE)
    point.torque = point.torque + moduli.couple * (trace_A * z - A * z);
  for (int k = 0; k < FREE; ++k) {
    b[k] = point.R * gradients[k];
    at.force[k] = at.force[k] + s * b[k] + (2.0 * moduli.mu) * (F * gradients[k]);
    if constexpr (COUPLE)
      at.force[k] = at.force[k] - cross(moduli.couple * z, b[k]);
  }
  if constexpr (ORDER == Order::gradient)
    return;

  point.K = plus_identity(s * A, -s * trace_A) + square_scaled(moduli.lambda, z);
  Mat Y{};
  if constexpr (COUPLE) {
    Y = plus_identity(-transposed(V), trace_A);
    const Sym YtY = plus_identity(square(F) - 2.0 * trace_A * A, trace_A * trace_A);
    point.K = point.K - moduli.couple * plus_identity(YtY - symmetric_part(cross(z, V)), -dot(z, z));
  }
  const Vec zeta = D_transposed_times(point, z);
  const Mat D = D_matrix(point);
  const Mat G = COUPLE ? times_D(plus_identity(moduli.couple * Y, s), point) : s * D;
  for (int k = 0; k < FREE; ++k) {
    point.mixed[k] = outer((COUPLE ? moduli.lambda + moduli.couple : moduli.lambda) * b[k], zeta) - cross(b[k], G);
    if constexpr (COUPLE)
      point.mixed[k] = point.mixed[k] - (moduli.couple * dot(z, b[k])) * D;
  }
  int i = 0;
  for (int k = 0; k < FREE; ++k) {
    for (int l = k; l < FREE; ++l, ++i) {
      const Real metric = dot(gradients[k], gradients[l]);
      Mat block = outer(moduli.lambda * b[k], b[l]);
      Real diagonal = 2.0 * moduli.mu * metric;
      if constexpr (COUPLE) {
        block = block + outer(moduli.couple * b[l], b[k]);
        diagonal -= moduli.couple * metric;
      }
      at.blocks[i] = at.blocks[i] + plus_identity(block, diagonal);
    }
  }
}

/// A limit on the stretch of a membrane: sum of modulus/6 <l_i - l_max>^3 over the two squared principal stretches l_i.
/// `first`, `second` span the plane of the rest shape.
template <class Shape, Order ORDER>
WRY_INLINE void add_stretch_limit(const Mat& F, const Vec* gradients, const Vec& first, const Vec& second, Real most,
                                  Real modulus, PointStretch<Shape>& at) {
  const Vec f1 = F * first, f2 = F * second;
  const Real xx = dot(f1, f1), xy = dot(f1, f2), yy = dot(f2, f2);
  const Real mean = 0.5 * (xx + yy), half = 0.5 * (xx - yy);
  const Real radius = sqrt(half * half + xy * xy);
  const Real zero{};
  const Real over1 = mean + radius > most ? mean + radius - most : zero;
  const Real over2 = mean - radius > most ? mean - radius - most : zero;
  at.energy += modulus * (1.0 / 6.0) * (over1 * over1 * over1 + over2 * over2 * over2);
  if constexpr (ORDER == Order::energy)
    return;
  // f'(C) = p I + q (C - mean I); q is the divided difference of f', which has a limit where the stretches are equal.
  const Real slope1 = 0.5 * modulus * over1 * over1, slope2 = 0.5 * modulus * over2 * over2;
  const Real p = 0.5 * (slope1 + slope2);
  const auto apart = radius > 1e-12 * mean;
  const Real safe = apart ? radius : broadcast(1.0);
  const Real q = apart ? 0.5 * (slope1 - slope2) / safe : modulus * over1;
  const Real cosine = apart ? half / safe : broadcast(1.0), sine = apart ? xy / safe : zero;
  constexpr int FREE = PointStretch<Shape>::FREE;
  Vec M[FREE], E[FREE], N[FREE];
  for (int k = 0; k < FREE; ++k) {
    const Real g1 = dot(gradients[k], first), g2 = dot(gradients[k], second);
    M[k] = g1 * f1 + g2 * f2;
    E[k] = (cosine * g1 + sine * g2) * f1 + (sine * g1 - cosine * g2) * f2;
    N[k] = (cosine * g2 - sine * g1) * f1 + (cosine * g1 + sine * g2) * f2;
    at.force[k] = at.force[k] + 2.0 * p * M[k] + (2.0 * q * radius) * E[k];
  }
  if constexpr (ORDER == Order::gradient)
    return;
  const Real even = modulus * (over1 + over2), odd = modulus * (over1 - over2);
  int i = 0;
  for (int k = 0; k < FREE; ++k) {
    const Real k1 = dot(gradients[k], first), k2 = dot(gradients[k], second);
    for (int l = k; l < FREE; ++l, ++i) {
      const Real l1 = dot(gradients[l], first), l2 = dot(gradients[l], second);
      const Real stress =
          p * (k1 * l1 + k2 * l2) + q * radius * (k1 * (cosine * l1 + sine * l2) + k2 * (sine * l1 - cosine * l2));
      const Mat stiffness =
          outer(M[k], even * M[l] + odd * E[l]) + outer(E[k], odd * M[l] + even * E[l]) + outer(N[k], (2.0 * q) * N[l]);
      at.blocks[i] = at.blocks[i] + plus_identity(stiffness, 2.0 * stress);
    }
  }
}

} // namespace wry::fem::WRY_ISA
