#pragma once

#include "sim/fem/kernels/element.h"

/// The rotations of the quadrature points and the chain from the increments of the nodes to them.
///
/// A point's increment is a = sum phi_k(p) a_k, its rotation cay(a) q0; a variation of a turns it by D delta a in the
/// world frame, D = (I + cross(a)/2) / n^2, n^2 = 1 + |a|^2/4 (spec §1). With t and K the first and second derivative
/// of an energy along turns exp(theta), those by a are tau = D^T t and D^T K D - (a tau^T + tau a^T) / (4 n^2).
namespace wry::fem::WRY_ISA {

/// phi_k(p) = FAR + (k == p ? NEAR - FAR : 0)
inline constexpr double FAR = 0.1381966011250105;
inline constexpr double NEAR = 0.5854101966249685;

struct Point {
  Vec half;     ///< a / 2
  Real inverse; ///< 1 / n^2
  Mat R;
  Vec torque;   ///< dE/d theta
  Sym K;        ///< d2E/d theta^2 along exp(theta)
  Mat mixed[3]; ///< d2E/dx_k da for nodes 1..3
};

struct Points {
  Point point[POINTS];
};

/// D^T v
WRY_INLINE Vec D_transposed_times(const Point& point, const Vec& v) {
  return point.inverse * (v - cross(point.half, v));
}
WRY_INLINE Mat D_matrix(const Point& point) {
  const Vec h = point.inverse * point.half;
  return {{point.inverse, -h.z, h.y}, {h.z, point.inverse, -h.x}, {-h.y, h.x, point.inverse}};
}
/// m D
WRY_INLINE Mat times_D(const Mat& m, const Point& point) {
  // (m cross(h)) row by row: r cross(h) = r x h
  const Mat turned = {m.r0 + cross(m.r0, point.half), m.r1 + cross(m.r1, point.half), m.r2 + cross(m.r2, point.half)};
  return point.inverse * turned;
}

/// a of the points, from those of the nodes.
WRY_INLINE void interpolate(const Batch& batch, const NodeFields& fields, int lane, Vec (&increments)[POINTS]) {
  for (int k = 0; k < 4; ++k)
    increments[k] = gather_vec(fields.rotation_increments, batch.nodes + k * LANES + lane);
  const Vec common = broadcast(FAR) * (increments[0] + increments[1] + increments[2] + increments[3]);
  for (int p = 0; p < POINTS; ++p)
    increments[p] = common + broadcast(NEAR - FAR) * increments[p];
}

WRY_INLINE void load_points(const Batch& batch, const NodeFields& fields, int lane, Points& points) {
  Vec increments[POINTS];
  interpolate(batch, fields, lane, increments);
  for (int p = 0; p < POINTS; ++p) {
    Point& point = points.point[p];
    point.half = broadcast(0.5) * increments[p];
    point.inverse = 1.0 / (1.0 + dot(point.half, point.half));
    const Quat q0 = load_quat(batch.point_rotations + 4 * p * LANES + lane);
    point.R = point.inverse * scaled_rotation(q0 + point.half * q0);
  }
}

/// The blocks (x_k, a_l) and (a_k, x_l) of all nodes.
WRY_INLINE void store_mixed_blocks(double* hessian, const Points& points) {
  constexpr int SIZE = 36 * LANES;
  Mat sum[3];
  for (int k = 0; k < 3; ++k) {
    const Mat all =
        (points.point[0].mixed[k] + points.point[1].mixed[k]) + (points.point[2].mixed[k] + points.point[3].mixed[k]);
    sum[k] = broadcast(FAR) * all;
  }
  for (int l = 0; l < 4; ++l) {
    Mat column[4];
    for (int k = 0; k < 3; ++k)
      column[k + 1] = sum[k] + broadcast(NEAR - FAR) * points.point[l].mixed[k];
    column[0] = -(column[1] + column[2] + column[3]);
    for (int k = 0; k < 4; ++k) {
      if (k <= l)
        store_block(hessian + SIZE * block_number(k, l) + 3 * LANES, 6, column[k]);
      if (k >= l)
        store_block(hessian + SIZE * block_number(l, k) + 18 * LANES, 6, transposed(column[k]));
    }
  }
}

/// Where the derivatives by the increments of the nodes are stored.
WRY_INLINE double* rotation_gradient(double* gradient, int k) {
  return gradient + (6 * k + 3) * LANES;
}
WRY_INLINE double* rotation_block(double* hessian, int k, int l) {
  return hessian + (36 * block_number(k, l) + 21) * LANES;
}

WRY_INLINE void add_to_vec(double* to, const Vec& v) {
  store_vec(to, load_vec(to) + v);
}
WRY_INLINE void add_to_block(double* to, const Mat& m) {
  add_to_vec(to, m.r0);
  add_to_vec(to + 6 * LANES, m.r1);
  add_to_vec(to + 12 * LANES, m.r2);
}

/// Whether derivatives replace what is stored or are added to it.
enum class Writing { store, add };

/// The gradient by a and the blocks (a_k, a_l) through the rotations of the points.
template <Order ORDER, Writing WRITING>
WRY_INLINE void write_rotation_derivatives(double* gradient, double* hessian, const Points& points) {
  Vec tau[POINTS];
  Sym second[POINTS];
  for (int p = 0; p < POINTS; ++p) {
    const Point& point = points.point[p];
    tau[p] = D_transposed_times(point, point.torque);
    if constexpr (ORDER == Order::hessian) {
      // D^T K D: K D by rows, then D^T by columns, of which the upper triangle is enough
      const Mat KD = times_D(full(point.K), point);
      const Vec h = point.half;
      const Mat turned = KD - cross(h, KD);
      const Sym DKD = {turned.r0.x, turned.r0.y, turned.r0.z, turned.r1.y, turned.r1.z, turned.r2.z};
      second[p] = point.inverse * (DKD - symmetric_outer(broadcast(0.5) * h, tau[p]));
    }
  }
  const Vec common = broadcast(FAR) * ((tau[0] + tau[1]) + (tau[2] + tau[3]));
  for (int k = 0; k < 4; ++k) {
    const Vec sum = common + broadcast(NEAR - FAR) * tau[k];
    if constexpr (WRITING == Writing::add)
      add_to_vec(rotation_gradient(gradient, k), sum);
    else
      store_vec(rotation_gradient(gradient, k), sum);
  }
  if constexpr (ORDER != Order::hessian)
    return;
  // phi_k phi_l = FAR^2 + FAR (NEAR - FAR) (delta_k + delta_l) + (NEAR - FAR)^2 delta_k delta_l
  const Sym all = broadcast(FAR * FAR) * ((second[0] + second[1]) + (second[2] + second[3]));
  Sym own[4];
  for (int k = 0; k < 4; ++k)
    own[k] = broadcast(FAR * (NEAR - FAR)) * second[k];
  for (int k = 0; k < 4; ++k) {
    for (int l = k; l < 4; ++l) {
      Sym sum = all + own[k] + own[l];
      if (k == l)
        sum = sum + broadcast((NEAR - FAR) * (NEAR - FAR)) * second[k];
      if constexpr (WRITING == Writing::add)
        add_to_block(rotation_block(hessian, k, l), full(sum));
      else
        store_block(rotation_block(hessian, k, l), 6, full(sum));
    }
  }
}

} // namespace wry::fem::WRY_ISA
