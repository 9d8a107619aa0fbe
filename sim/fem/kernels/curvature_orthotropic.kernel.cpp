#include "sim/fem/kernels/nodal_rotations.h"

/// mu L_c^2 sum of C_ij (B^T Gamma B)_ij^2 in the frame of the material's axes. All rotations are multiplied by the
/// quaternion of B from the right and shape functions differentiated along the axes, so that B is the identity from
/// there on; then column j is Gamma_j = 2 u_j, (c_j, u_j) = conj(q_p) Q_j, Q_j = sum of q_k d phi_k / dX_j.
namespace wry::fem::WRY_ISA {

namespace {

/// The quaternion of a matrix with orthonormal columns. Of -B if B mirrors, which only changes signs that are squared.
WRY_INLINE Quat quaternion_of(Mat m) {
  const Real det = dot(cross(m.r0, m.r1), m.r2);
  m = (det < 0.0 ? broadcast(-1.0) : broadcast(1.0)) * m;
  const Vec a = axial(m);
  const Real xy = m.r0.y + m.r1.x, xz = m.r0.z + m.r2.x, yz = m.r1.z + m.r2.y;
  // Four multiples of the quaternion; the one whose own component is largest is safe to normalise.
  const Quat candidates[3] = {{a.x, 1.0 + m.r0.x - m.r1.y - m.r2.z, xy, xz},
                              {a.y, xy, 1.0 - m.r0.x + m.r1.y - m.r2.z, yz},
                              {a.z, xz, yz, 1.0 - m.r0.x - m.r1.y + m.r2.z}};
  Quat best = {1.0 + trace(m), a.x, a.y, a.z};
  Real size = best.w;
  const Real own[3] = {candidates[0].x, candidates[1].y, candidates[2].z};
  for (int i = 0; i < 3; ++i) {
    const auto better = own[i] > size;
    best = {better ? candidates[i].w : best.w, better ? candidates[i].x : best.x, better ? candidates[i].y : best.y,
            better ? candidates[i].z : best.z};
    size = better ? own[i] : size;
  }
  return (1.0 / sqrt(dot(best, best))) * best;
}

/// Geometry of an element along the material's axes.
struct Axes {
  Quat frame;       ///< of B
  Mat basis;        ///< B
  Vec gradients[3]; ///< of shape functions 1..3 along the axes
};

WRY_INLINE Axes load_axes(const Batch& batch, int lane, const Element& element) {
  Axes axes;
  const double* basis = batch.curvature_basis + lane;
  axes.basis = {load_vec(basis), load_vec(basis + 3 * LANES), load_vec(basis + 6 * LANES)};
  axes.frame = quaternion_of(axes.basis);
  for (int k = 0; k < 3; ++k)
    axes.gradients[k] = transposed_times(axes.basis, element.gradients[k]);
  return axes;
}

/// A column of the wryness at a point.
struct Column {
  Real c;
  Vec u;
  Vec stress; ///< dE/d Gamma_j
  Vec moduli; ///< the derivative of stress
};

/// d Gamma_j / d theta = -Z in the point's frame, Z = c I - cross(u); moduli * Z by rows
WRY_INLINE Mat scaled_turn(const Column& column) {
  const Vec& u = column.u;
  const Vec& h = column.moduli;
  return {{h.x * column.c, h.x * u.z, -(h.x * u.y)},
          {-(h.y * u.z), h.y * column.c, h.y * u.x},
          {h.z * u.y, -(h.z * u.x), h.z * column.c}};
}

/// Z^T m, of which the upper triangle
WRY_INLINE Sym turned_stiffness(const Column& column, const Mat& m) {
  const Mat Ztm = column.c * m + cross(column.u, m);
  return {Ztm.r0.x, Ztm.r0.y, Ztm.r0.z, Ztm.r1.y, Ztm.r1.z, Ztm.r2.z};
}

/// d2E/da dQ_j: by theta and the quaternion relative to the point's, with C = D^T R from the left and the point's
/// quaternion from the right.
WRY_INLINE Mat34 column_mixed(const Column& column, const Mat& scaled, const Mat& chain, const Quat& q) {
  const Mat by_vector = plus_cross(broadcast(-2.0) * transposed(scaled), column.stress);
  const Vec by_scalar = -(chain * column.stress);
  const Mat turned = chain * by_vector;
  const auto row = [&](Real scalar, const Vec& v) { return q * Quat{scalar, v.x, v.y, v.z}; };
  return {row(by_scalar.x, turned.r0), row(by_scalar.y, turned.r1), row(by_scalar.z, turned.r2)};
}

/// The blocks by two quaternions: sums over points and rows of weights g_i g_i^T, where g_i takes component i of the
/// vector part of conj(q) Q: g_x = (-x, w, z, -y), g_y = (-y, -z, w, x), g_z = (-z, y, -x, w). `q` is the sum of q q^T.
WRY_INLINE void fill_blocks(const Sym4& q, const Mat& moduli, const Vec (&gradients)[3], Sym4 (&blocks)[10]) {
  int i = 4;
  for (int k = 0; k < 3; ++k) {
    for (int l = k; l < 3; ++l, ++i) {
      const Vec products = {4.0 * gradients[k].x * gradients[l].x, 4.0 * gradients[k].y * gradients[l].y,
                            4.0 * gradients[k].z * gradients[l].z};
      const Vec h = moduli * products;
      blocks[i] = {h.x * q.xx + h.y * q.yy + h.z * q.zz, h.y * q.yz - h.x * q.wx - h.z * q.yz,
                   h.z * q.xz - h.x * q.xz - h.y * q.wy, h.x * q.xy - h.y * q.xy - h.z * q.wz,
                   h.x * q.ww + h.y * q.zz + h.z * q.yy, h.x * q.wz - h.y * q.wz - h.z * q.xy,
                   h.z * q.wy - h.x * q.wy - h.y * q.xz, h.x * q.zz + h.y * q.ww + h.z * q.xx,
                   h.y * q.wx - h.x * q.yz - h.z * q.wx, h.x * q.yy + h.y * q.xx + h.z * q.ww};
    }
  }
}

/// Gamma0 along the axes: B^T Gamma0 B, by columns.
WRY_INLINE void load_rest_columns(const Batch& batch, int lane, int p, const Mat* basis, Vec (&columns)[3]) {
  const double* rest = batch.rest_curvature + 9 * p * LANES + lane;
  Mat Gamma0 = {load_vec(rest), load_vec(rest + 3 * LANES), load_vec(rest + 6 * LANES)};
  if (basis != nullptr)
    Gamma0 = transposed(*basis) * Gamma0 * *basis;
  const Mat turned = transposed(Gamma0);
  columns[0] = turned.r0;
  columns[1] = turned.r1;
  columns[2] = turned.r2;
}

} // namespace

template <Order ORDER>
void add_orthotropic_curvature(const Batch& batch, const NodeFields& fields, int lane, const Element& element,
                               Points& points, Real& energy, double* gradient, double* hessian) {
  Axes axes;
  const bool turned = batch.curvature_basis != nullptr;
  if (turned)
    axes = load_axes(batch, lane, element);
  else {
    for (int k = 0; k < 3; ++k)
      axes.gradients[k] = element.gradients[k];
  }
  const double* entries = batch.curvature_moduli + lane;
  const Real weight = 0.5 * element.volume; // twice that of a point: C_ij Gamma_ij^2 has no 1/2
  const Mat moduli = weight * Mat{load_vec(entries), load_vec(entries + 3 * LANES), load_vec(entries + 6 * LANES)};
  const Mat turned_moduli = transposed(moduli);
  const Vec columns[3] = {turned_moduli.r0, turned_moduli.r1, turned_moduli.r2};
  NodalRotations nodal;
  load_nodal_rotations<ORDER>(batch, fields, lane, turned ? &axes.frame : nullptr, nodal);
  const Quat steps[3] = {nodal.q[1] - nodal.q[0], nodal.q[2] - nodal.q[0], nodal.q[3] - nodal.q[0]};
  const Quat Q[3] = {axes.gradients[0].x * steps[0] + axes.gradients[1].x * steps[1] + axes.gradients[2].x * steps[2],
                     axes.gradients[0].y * steps[0] + axes.gradients[1].y * steps[1] + axes.gradients[2].y * steps[2],
                     axes.gradients[0].z * steps[0] + axes.gradients[1].z * steps[1] + axes.gradients[2].z * steps[2]};

  Quat by_columns[3] = {};
  QuaternionDerivatives<Sym4> by_q;
  Sym4 sum{};
  for (int p = 0; p < POINTS; ++p) {
    Point& point = points.point[p];
    Quat q0 = load_quat(batch.point_rotations + 4 * p * LANES + lane);
    if (turned)
      q0 = q0 * axes.frame;
    const Quat q = sqrt(point.inverse) * (q0 + point.half * q0);
    const Quat back = conjugate(q);
    Vec rest[3] = {};
    if (batch.rest_curvature != nullptr)
      load_rest_columns(batch, lane, p, turned ? &axes.basis : nullptr, rest);
    Mat34 mixed[3];
    Vec torque{};
    Sym K{};
    Real work{};
    const Mat R = turned ? scaled_rotation(q) : point.R;
    const Mat chain = transposed(times_D(transposed(R), point)); // D^T R
    for (int j = 0; j < 3; ++j) {
      const Quat relative = back * Q[j];
      const Vec h = columns[j];
      Column column;
      column.c = relative.w;
      column.u = vector_part(relative);
      column.moduli = h;
      const Vec excess = broadcast(2.0) * column.u - rest[j];
      column.stress = {h.x * excess.x, h.y * excess.y, h.z * excess.z};
      energy += 0.5 * dot(column.stress, excess);
      if constexpr (ORDER == Order::energy)
        continue;
      torque = torque - (column.c * column.stress + cross(column.u, column.stress));
      by_columns[j] = by_columns[j] + broadcast(2.0) * (q * column.stress);
      if constexpr (ORDER == Order::hessian) {
        work += dot(column.stress, column.u);
        const Mat scaled = scaled_turn(column);
        K = K + turned_stiffness(column, scaled);
        mixed[j] = column_mixed(column, scaled, chain, q);
      }
    }
    if constexpr (ORDER == Order::energy)
      continue;
    point.torque = point.torque + R * torque;
    if constexpr (ORDER == Order::hessian) {
      const Mat RK = R * full(K);
      const Sym world = {dot(RK.r0, R.r0), dot(RK.r0, R.r1), dot(RK.r0, R.r2),
                         dot(RK.r1, R.r1), dot(RK.r1, R.r2), dot(RK.r2, R.r2)};
      point.K = point.K + plus_identity(world, -0.5 * work);
      for (int k = 0; k < 3; ++k)
        by_q.mixed[p][k] =
            axes.gradients[k].x * mixed[0] + axes.gradients[k].y * mixed[1] + axes.gradients[k].z * mixed[2];
      sum = sum + square(q);
    }
  }
  if constexpr (ORDER == Order::energy)
    return;
  for (int k = 0; k < 3; ++k)
    by_q.gradient[k] =
        axes.gradients[k].x * by_columns[0] + axes.gradients[k].y * by_columns[1] + axes.gradients[k].z * by_columns[2];
  if constexpr (ORDER == Order::hessian)
    fill_blocks(sum, moduli, axes.gradients, by_q.blocks);
  chain_to_increments<ORDER>(nodal, by_q, gradient, hessian);
}

template void add_orthotropic_curvature<Order::energy>(const Batch&, const NodeFields&, int, const Element&, Points&,
                                                       Real&, double*, double*);
template void add_orthotropic_curvature<Order::gradient>(const Batch&, const NodeFields&, int, const Element&, Points&,
                                                         Real&, double*, double*);
template void add_orthotropic_curvature<Order::hessian>(const Batch&, const NodeFields&, int, const Element&, Points&,
                                                        Real&, double*, double*);

} // namespace wry::fem::WRY_ISA
