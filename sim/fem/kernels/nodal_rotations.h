#pragma once

#include "sim/fem/kernels/curvature.h"

/// The rotations of the nodes, whose quaternions are differentiated for the curvature, and the chain from their
/// increments.
namespace wry::fem::WRY_ISA {

struct NodalRotations {
  Quat q[4];             ///< cay(a) q0, times the frame
  Vec increment[4];      ///< a
  Real inverse[4];       ///< 1 / n^2
  Quat derivative[4][3]; ///< dq / da_c (spec §1)
};

/// `frame` multiplies all rotations from the right: columns of R become other material axes.
template <Order ORDER>
WRY_INLINE void load_nodal_rotations(const Batch& batch, const NodeFields& fields, int lane, const Quat* frame,
                                     NodalRotations& nodal) {
  for (int k = 0; k < 4; ++k) {
    const std::int32_t* nodes = batch.nodes + k * LANES + lane;
    const Vec a = gather_vec(fields.rotation_increments, nodes);
    Quat q0 = gather_quat(fields.rotations, nodes);
    if (frame != nullptr)
      q0 = q0 * *frame;
    const Vec half = broadcast(0.5) * a;
    const Real inverse = 1.0 / (1.0 + dot(half, half));
    const Real root = sqrt(inverse);
    const Quat q = root * (q0 + half * q0);
    nodal.q[k] = q;
    if constexpr (ORDER == Order::energy)
      continue;
    nodal.increment[k] = a;
    nodal.inverse[k] = inverse;
    const Quat base = (0.5 * root) * q0;
    const Vec pull = (0.25 * inverse) * a;
    nodal.derivative[k][0] = Quat{-base.x, base.w, -base.z, base.y} - pull.x * q;
    nodal.derivative[k][1] = Quat{-base.y, base.z, base.w, -base.x} - pull.y * q;
    nodal.derivative[k][2] = Quat{-base.z, -base.y, base.x, base.w} - pull.z * q;
  }
}

/// A 3 x 4 and a 4 x 4 matrix, by rows.
struct Mat34 {
  Quat r0, r1, r2;
};
WRY_INLINE Mat34 operator+(const Mat34& a, const Mat34& b) {
  return {a.r0 + b.r0, a.r1 + b.r1, a.r2 + b.r2};
}
WRY_INLINE Mat34 operator-(const Mat34& a) {
  return {-a.r0, -a.r1, -a.r2};
}
WRY_INLINE Mat34 operator*(Real s, const Mat34& a) {
  return {s * a.r0, s * a.r1, s * a.r2};
}

struct Mat4 {
  Quat r0, r1, r2, r3;
};
WRY_INLINE Mat4 operator+(const Mat4& a, const Mat4& b) {
  return {a.r0 + b.r0, a.r1 + b.r1, a.r2 + b.r2, a.r3 + b.r3};
}
WRY_INLINE Mat4 operator-(const Mat4& a) {
  return {-a.r0, -a.r1, -a.r2, -a.r3};
}
WRY_INLINE Mat4 operator*(Real s, const Mat4& a) {
  return {s * a.r0, s * a.r1, s * a.r2, s * a.r3};
}
WRY_INLINE Mat4 outer(const Quat& a, const Quat& b) {
  return {a.w * b, a.x * b, a.y * b, a.z * b};
}
WRY_INLINE Mat4 transposed(const Mat4& a) {
  return {{a.r0.w, a.r1.w, a.r2.w, a.r3.w},
          {a.r0.x, a.r1.x, a.r2.x, a.r3.x},
          {a.r0.y, a.r1.y, a.r2.y, a.r3.y},
          {a.r0.z, a.r1.z, a.r2.z, a.r3.z}};
}

/// A symmetric 4 x 4 matrix.
struct Sym4 {
  Real ww, wx, wy, wz, xx, xy, xz, yy, yz, zz;
};
WRY_INLINE Sym4 operator+(const Sym4& a, const Sym4& b) {
  return {a.ww + b.ww, a.wx + b.wx, a.wy + b.wy, a.wz + b.wz, a.xx + b.xx,
          a.xy + b.xy, a.xz + b.xz, a.yy + b.yy, a.yz + b.yz, a.zz + b.zz};
}
WRY_INLINE Sym4 operator-(const Sym4& a) {
  return {-a.ww, -a.wx, -a.wy, -a.wz, -a.xx, -a.xy, -a.xz, -a.yy, -a.yz, -a.zz};
}
WRY_INLINE Sym4 operator*(Real s, const Sym4& a) {
  return {s * a.ww, s * a.wx, s * a.wy, s * a.wz, s * a.xx, s * a.xy, s * a.xz, s * a.yy, s * a.yz, s * a.zz};
}
WRY_INLINE Sym4 transposed(const Sym4& a) {
  return a;
}
/// q q^T
WRY_INLINE Sym4 square(const Quat& q) {
  return {q.w * q.w, q.w * q.x, q.w * q.y, q.w * q.z, q.x * q.x, q.x * q.y, q.x * q.z, q.y * q.y, q.y * q.z, q.z * q.z};
}
WRY_INLINE Mat4 full(const Sym4& a) {
  return {{a.ww, a.wx, a.wy, a.wz}, {a.wx, a.xx, a.xy, a.xz}, {a.wy, a.xy, a.yy, a.yz}, {a.wz, a.xz, a.yz, a.zz}};
}
WRY_INLINE Mat4 full(const Mat4& a) {
  return a;
}

/// Derivatives of a curvature energy by the quaternions of nodes 1..3; node 0 is minus their sum.
template <class Block> struct QuaternionDerivatives {
  Quat gradient[3];
  Block blocks[10];       ///< by q_k and q_l, ordered as in BatchDerivatives; the first four are made from the others
  Mat34 mixed[POINTS][3]; ///< by the increment of point p and q_k
};

/// m J: a 3 x 4 matrix times the derivative of a node's quaternion
WRY_INLINE Mat times_derivative(const Mat34& m, const Quat (&derivative)[3]) {
  const auto row = [&](const Quat& r) {
    return Vec{dot(r, derivative[0]), dot(r, derivative[1]), dot(r, derivative[2])};
  };
  return {row(m.r0), row(m.r1), row(m.r2)};
}

/// J^T m
WRY_INLINE Mat34 derivative_times(const Quat (&derivative)[3], const Mat4& m) {
  const auto row = [&](const Quat& d) { return d.w * m.r0 + d.x * m.r1 + d.y * m.r2 + d.z * m.r3; };
  return {row(derivative[0]), row(derivative[1]), row(derivative[2])};
}

/// The second derivative of g.q(a) by the node's own increment beyond J, for tau = J^T g.
WRY_INLINE Sym quaternion_curvature(const NodalRotations& nodal, int k, const Quat& g, const Vec& tau) {
  // D^T (-(g.q)/4 I) D - (a tau^T + tau a^T) / (4 n^2) with D^T D = I / n^2 - a a^T / (4 n^4)
  const Real inverse = nodal.inverse[k];
  const Real pull = 0.25 * inverse * dot(g, nodal.q[k]);
  const Vec& a = nodal.increment[k];
  const Sym sides = square_scaled(0.25 * inverse * pull, a) - symmetric_outer((0.25 * inverse) * a, tau);
  return plus_identity(sides, -pull);
}

/// From quaternions to increments: writes the gradient by a and the blocks (a_k, a_l).
template <Order ORDER, class Block>
WRY_INLINE void chain_to_increments(const NodalRotations& nodal, QuaternionDerivatives<Block>& by_q, double* gradient,
                                    double* hessian) {
  const Quat g[4] = {-(by_q.gradient[0] + by_q.gradient[1] + by_q.gradient[2]), by_q.gradient[0], by_q.gradient[1],
                     by_q.gradient[2]};
  Vec tau[4];
  for (int k = 0; k < 4; ++k) {
    const Quat(&derivative)[3] = nodal.derivative[k];
    tau[k] = {dot(derivative[0], g[k]), dot(derivative[1], g[k]), dot(derivative[2], g[k])};
    store_vec(rotation_gradient(gradient, k), tau[k]);
  }
  if constexpr (ORDER != Order::hessian)
    return;

  Block(&blocks)[10] = by_q.blocks;
  blocks[1] = -(blocks[4] + transposed(blocks[5]) + transposed(blocks[6]));
  blocks[2] = -(blocks[5] + blocks[7] + transposed(blocks[8]));
  blocks[3] = -(blocks[6] + blocks[8] + blocks[9]);
  blocks[0] = -(blocks[1] + blocks[2] + blocks[3]);

  Mat34 common[3];
  for (int k = 0; k < 3; ++k)
    common[k] = broadcast(FAR) * ((by_q.mixed[0][k] + by_q.mixed[1][k]) + (by_q.mixed[2][k] + by_q.mixed[3][k]));
  for (int k = 0; k < 4; ++k) {
    // By a_k through the points and by the quaternions of all nodes.
    Mat34 mixed[4];
    for (int l = 0; l < 3; ++l)
      mixed[l + 1] = common[l] + broadcast(NEAR - FAR) * by_q.mixed[k][l];
    mixed[0] = -(mixed[1] + mixed[2] + mixed[3]);
    for (int l = 0; l < k; ++l)
      add_to_block(rotation_block(hessian, l, k), transposed(times_derivative(mixed[l], nodal.derivative[l])));
    const Mat34 half = broadcast(0.5) * derivative_times(nodal.derivative[k], full(blocks[block_number(k, k)]));
    const Mat own = times_derivative(half + mixed[k], nodal.derivative[k]);
    const Sym sum = broadcast(2.0) * symmetric_part(own) + quaternion_curvature(nodal, k, g[k], tau[k]);
    store_block(rotation_block(hessian, k, k), 6, full(sum));
    for (int l = k + 1; l < 4; ++l) {
      const Mat34 both = derivative_times(nodal.derivative[k], full(blocks[block_number(k, l)])) + mixed[l];
      store_block(rotation_block(hessian, k, l), 6, times_derivative(both, nodal.derivative[l]));
    }
  }
}

} // namespace wry::fem::WRY_ISA
