#include "sim/fem/kernels/nodal_rotations.h"

/// Eq 12, mu L_c^2/2 (alpha |sym Gamma|^2 + beta |skew Gamma|^2 + gamma tr(Gamma)^2), in the world frame, where it has
/// the same form: Gamma_w = R Gamma R^T = 2 X, X = sum of vec(q_k conj(q_p)) b_k^T, b_k = R grad phi_k.
namespace wry::fem::WRY_ISA {

namespace {

/// 1/2 (plain |G|^2 + swapped G:G^T + trace tr(G)^2), times the weight of a point
struct Moduli {
  Real plain, swapped, trace;
};

/// What a point needs, in the world frame.
struct Wryness {
  Quat q;     ///< of the point
  Vec b[3];   ///< shape gradients
  Vec c;      ///< sum of <q_p, q_k> b_k: the part of the quaternions' gradient along q_p
  Mat X;      ///< half the wryness
  Mat excess; ///< wryness beyond that at rest
};

WRY_INLINE Moduli load_moduli(const Batch& batch, int lane, Real weight) {
  const Vec m = load_vec(batch.curvature_moduli + lane);
  return {0.5 * weight * (m.x + m.y), 0.5 * weight * (m.x - m.y), weight * m.z};
}

WRY_INLINE Wryness measure(const Batch& batch, int lane, int p, const Element& element, const Point& point,
                           const Quat (&steps)[3]) {
  Wryness w;
  const Quat q0 = load_quat(batch.point_rotations + 4 * p * LANES + lane);
  w.q = sqrt(point.inverse) * (q0 + point.half * q0);
  const Quat back = conjugate(w.q);
  w.c = Vec{};
  w.X = Mat{};
  for (int k = 0; k < 3; ++k) {
    w.b[k] = point.R * element.gradients[k];
    const Quat relative = steps[k] * back;
    w.c = w.c + relative.w * w.b[k];
    w.X = w.X + outer(vector_part(relative), w.b[k]);
  }
  w.excess = w.X + w.X;
  if (batch.rest_curvature != nullptr) {
    const double* rest = batch.rest_curvature + 9 * p * LANES + lane;
    const Mat rest_curvature = {load_vec(rest), load_vec(rest + 3 * LANES), load_vec(rest + 6 * LANES)};
    w.excess = w.excess - point.R * rest_curvature * transposed(point.R);
  }
  return w;
}

/// d2E/d theta^2 of a point. A turn changes the wryness by -(theta c^T + cross(theta) X).
WRY_INLINE Sym point_stiffness(const Moduli& moduli, const Wryness& w, const Mat& stress) {
  const Mat& X = w.X;
  const Vec z = axial(X);
  const Vec d = w.c - z;
  const Sym XXt = square(X);
  const Mat cofactor = {cross(X.r1, X.r2), cross(X.r2, X.r0), cross(X.r0, X.r1)};
  const Real work = dot(stress.r0, X.r0) + dot(stress.r1, X.r1) + dot(stress.r2, X.r2);
  const Sym swapped = square(w.c) + square(z) - broadcast(2.0) * symmetric_part(cross(w.c, X) + cofactor);
  const Sym sum = moduli.swapped * swapped - moduli.plain * XXt + square_scaled(moduli.trace, d);
  return plus_identity(sum, moduli.plain * (dot(w.c, w.c) + XXt.xx + XXt.yy + XXt.zz) - 0.5 * work);
}

/// d2E/da dq_k of a point: by theta and the quaternion relative to the point's, then D^T from the left and the point's
/// quaternion from the right.
WRY_INLINE Mat34 point_mixed(const Moduli& moduli, const Wryness& w, const Vec& d, const Point& point, int k,
                             const Vec& m) {
  const Vec& b = w.b[k];
  const Mat bX = cross(b, w.X);
  const Mat first =
      plus_cross(plus_identity(outer(moduli.trace * d, b), moduli.plain * dot(w.c, b)), moduli.plain * (w.X * b));
  const Mat second = outer(b, w.c) - bX;
  const Mat sum = plus_cross(broadcast(-2.0) * (first + moduli.swapped * second), m);
  const Vec scalar = -m;
  const Vec turned_scalar = scalar - cross(point.half, scalar);
  const Mat turned = sum - cross(point.half, sum);
  const Quat q = point.inverse * w.q;
  return {Quat{turned_scalar.x, turned.r0.x, turned.r0.y, turned.r0.z} * q,
          Quat{turned_scalar.y, turned.r1.x, turned.r1.y, turned.r1.z} * q,
          Quat{turned_scalar.z, turned.r2.x, turned.r2.y, turned.r2.z} * q};
}

/// beta_k = (0, b_k) q_p of a point: how its wryness feels the quaternions of the nodes.
struct Feelers {
  Quat beta[3];
};

/// The blocks by two quaternions: sums over the points of 4 (trace beta_k beta_l^T + swapped beta_l beta_k^T +
/// plain b_k.b_l (I - q_p q_p^T)). `rotations` is the sum of q_p q_p^T.
WRY_INLINE void fill_blocks(const Feelers (&points)[POINTS], const Sym4& rotations, const Moduli& moduli,
                            const Element& element, Mat4 (&blocks)[10]) {
  const Real tr = 4.0 * moduli.trace, swapped = 4.0 * moduli.swapped, plain = 4.0 * moduli.plain;
  int i = 4;
  for (int k = 0; k < 3; ++k) {
    for (int l = k; l < 3; ++l, ++i) {
      Mat4 products = outer(points[0].beta[k], points[0].beta[l]);
      for (int p = 1; p < POINTS; ++p)
        products = products + outer(points[p].beta[k], points[p].beta[l]);
      const Real metric = plain * dot(element.gradients[k], element.gradients[l]);
      Mat4 block = tr * products + swapped * transposed(products) + full((-metric) * rotations);
      block.r0.w += 4.0 * metric;
      block.r1.x += 4.0 * metric;
      block.r2.y += 4.0 * metric;
      block.r3.z += 4.0 * metric;
      blocks[i] = block;
    }
  }
}

} // namespace

template <Order ORDER>
void add_isotropic_curvature(const Batch& batch, const NodeFields& fields, int lane, const Element& element,
                             Points& points, Real& energy, double* gradient, double* hessian) {
  const Moduli moduli = load_moduli(batch, lane, 0.25 * element.volume);
  NodalRotations nodal;
  load_nodal_rotations<ORDER>(batch, fields, lane, nullptr, nodal);
  const Quat steps[3] = {nodal.q[1] - nodal.q[0], nodal.q[2] - nodal.q[0], nodal.q[3] - nodal.q[0]};
  QuaternionDerivatives<Mat4> by_q;
  for (Quat& g : by_q.gradient)
    g = Quat{};
  Feelers feelers[POINTS];
  Sym4 rotations{};
  for (int p = 0; p < POINTS; ++p) {
    Point& point = points.point[p];
    const Wryness w = measure(batch, lane, p, element, point, steps);
    const Mat stress =
        plus_identity(moduli.plain * w.excess + moduli.swapped * transposed(w.excess), moduli.trace * trace(w.excess));
    energy += 0.5 * (dot(stress.r0, w.excess.r0) + dot(stress.r1, w.excess.r1) + dot(stress.r2, w.excess.r2));
    if constexpr (ORDER == Order::energy)
      continue;
    point.torque = point.torque - (stress * w.c + axial(stress * transposed(w.X)));
    for (int k = 0; k < 3; ++k) {
      const Vec m = stress * w.b[k];
      by_q.gradient[k] = by_q.gradient[k] + broadcast(2.0) * (m * w.q);
      if constexpr (ORDER == Order::hessian)
        by_q.mixed[p][k] = point_mixed(moduli, w, w.c - axial(w.X), point, k, m);
    }
    if constexpr (ORDER == Order::hessian) {
      point.K = point.K + point_stiffness(moduli, w, stress);
      for (int k = 0; k < 3; ++k)
        feelers[p].beta[k] = w.b[k] * w.q;
      rotations = rotations + square(w.q);
    }
  }
  if constexpr (ORDER == Order::hessian)
    fill_blocks(feelers, rotations, moduli, element, by_q.blocks);
  if constexpr (ORDER != Order::energy)
    chain_to_increments<ORDER>(nodal, by_q, gradient, hessian);
}

template void add_isotropic_curvature<Order::energy>(const Batch&, const NodeFields&, int, const Element&, Points&,
                                                     Real&, double*, double*);
template void add_isotropic_curvature<Order::gradient>(const Batch&, const NodeFields&, int, const Element&, Points&,
                                                       Real&, double*, double*);
template void add_isotropic_curvature<Order::hessian>(const Batch&, const NodeFields&, int, const Element&, Points&,
                                                      Real&, double*, double*);

} // namespace wry::fem::WRY_ISA
