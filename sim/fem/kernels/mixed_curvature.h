#pragma once

#include "sim/fem/kernels/mixed_strain.h"
#include "sim/fem/kernels/nodal_rotations.h"

/// Energies of curvature of mixed elements. Gamma_.j = 2 vec(conj(q) Q_j), Q_j = sum of g_kj q_k over corners k, in
/// axes that a frame turns from those of the rest shape; a variation of corner k's quaternion is one of rank one, 2
/// vec(conj(q) delta q_k) g_k^T, and a turn of the point by theta changes Gamma by -Z_j theta, Z_j = c_j I - cross(u_j)
/// with (c_j, u_j) = conj(q) Q_j, all in the point's axes.
namespace wry::fem::WRY_ISA {

/// The energy's moduli of WIDTH elements: stress(Gamma) is linear and symmetric.
struct CurvatureLaw {
  MixedCurvature model = MixedCurvature::none;
  Mat moduli; ///< isotropic, plate: a, b, c in the first row

  /// Columns of the stress from the columns of Gamma.
  template <int DIM> WRY_INLINE void stress(const Vec (&gamma)[DIM], Vec (&out)[DIM]) const {
    if constexpr (DIM == 2) {
      const Real both = 0.5 * (moduli.r0.x + moduli.r0.y), difference = 0.5 * (moduli.r0.x - moduli.r0.y);
      const Real trace = moduli.r0.z * (gamma[0].y - gamma[1].x);
      // K = (Gamma_21, Gamma_22; -Gamma_11, -Gamma_12)
      out[0] = {both * gamma[0].x - difference * gamma[1].y, moduli.r0.x * gamma[0].y + trace, Real{}};
      out[1] = {moduli.r0.x * gamma[1].x - trace, both * gamma[1].y - difference * gamma[0].x, Real{}};
    } else if (model == MixedCurvature::isotropic) {
      const Real both = 0.5 * (moduli.r0.x + moduli.r0.y), difference = 0.5 * (moduli.r0.x - moduli.r0.y);
      const Real trace = moduli.r0.z * (gamma[0].x + gamma[1].y + gamma[2].z);
      out[0] = {moduli.r0.x * gamma[0].x + trace, both * gamma[0].y + difference * gamma[1].x,
                both * gamma[0].z + difference * gamma[2].x};
      out[1] = {both * gamma[1].x + difference * gamma[0].y, moduli.r0.x * gamma[1].y + trace,
                both * gamma[1].z + difference * gamma[2].y};
      out[2] = {both * gamma[2].x + difference * gamma[0].z, both * gamma[2].y + difference * gamma[1].z,
                moduli.r0.x * gamma[2].z + trace};
    } else {
      for (int j = 0; j < DIM; ++j) {
        const auto entry = [j](const Vec& row) { return j == 0 ? row.x : j == 1 ? row.y : row.z; };
        out[j] = {2.0 * entry(moduli.r0) * gamma[j].x, 2.0 * entry(moduli.r1) * gamma[j].y,
                  2.0 * entry(moduli.r2) * gamma[j].z};
      }
    }
  }
};

WRY_INLINE Real component(const Vec& v, int j) {
  return j == 0 ? v.x : j == 1 ? v.y : v.z;
}

/// What curvature needs of an element beside its points.
template <class Shape> struct CurvedElement {
  CurvatureLaw law;
  bool turned = false;
  Quat frame{};
  Mat axes{};                    ///< columns: the axes in the rest shape
  Vec gradients[Shape::CORNERS]; ///< along the axes
  NodalRotations nodal;
};

template <class Shape, Order ORDER>
WRY_INLINE void load_curved(const MixedBatch& batch, const NodeFields& fields, int lane, const Vec* gradients,
                            CurvedElement<Shape>& out) {
  out.law.model = batch.curvature;
  const double* moduli = batch.moduli + lane;
  out.law.moduli = Mat{};
  out.law.moduli.r0 = load_vec(moduli);
  if (batch.curvature == MixedCurvature::orthotropic) {
    out.law.moduli.r1 = load_vec(moduli + 3 * LANES);
    out.law.moduli.r2 = load_vec(moduli + 6 * LANES);
  }
  out.turned = batch.frame != nullptr;
  if (out.turned) {
    out.frame = load_quat(batch.frame + lane);
    out.axes = scaled_rotation(out.frame);
  }
  out.gradients[0] = Vec{};
  for (int k = 1; k < Shape::CORNERS; ++k) {
    out.gradients[k] = out.turned ? transposed_times(out.axes, gradients[k - 1]) : gradients[k - 1];
    out.gradients[0] = out.gradients[0] - out.gradients[k];
  }
  for (int k = 0; k < Shape::CORNERS; ++k) {
    const std::int32_t* nodes = batch.nodes + k * LANES + lane;
    const Vec a = gather_vec(fields.rotation_increments, nodes);
    Quat q0 = gather_quat(fields.rotations, nodes);
    if (out.turned)
      q0 = q0 * out.frame;
    const Vec half = broadcast(0.5) * a;
    const Real inverse = 1.0 / (1.0 + dot(half, half));
    const Real root = sqrt(inverse);
    const Quat q = root * (q0 + half * q0);
    out.nodal.q[k] = q;
    if constexpr (ORDER == Order::energy)
      continue;
    out.nodal.increment[k] = a;
    out.nodal.inverse[k] = inverse;
    const Quat base = (0.5 * root) * q0;
    const Vec pull = (0.25 * inverse) * a;
    out.nodal.derivative[k][0] = Quat{-base.x, base.w, -base.z, base.y} - pull.x * q;
    out.nodal.derivative[k][1] = Quat{-base.y, base.z, base.w, -base.x} - pull.y * q;
    out.nodal.derivative[k][2] = Quat{-base.z, -base.y, base.x, base.w} - pull.z * q;
  }
}

/// Gamma0 along the axes, by columns.
WRY_INLINE void load_rest(const MixedBatch& batch, int lane, int p, const Mat* axes, Vec (&columns)[3]) {
  const double* rest = batch.rest_curvature + 9 * p * LANES + lane;
  Mat Gamma0 = {load_vec(rest), load_vec(rest + 3 * LANES), load_vec(rest + 6 * LANES)};
  if (axes != nullptr)
    Gamma0 = transposed(*axes) * Gamma0 * *axes;
  const Mat turned = transposed(Gamma0);
  columns[0] = turned.r0;
  columns[1] = turned.r1;
  columns[2] = turned.r2;
}

/// Derivatives by the increments of the corners, summed over points.
template <class Shape> struct RotationSums {
  Quat by_q[Shape::CORNERS];
  Vec gradient[Shape::CORNERS];
  Mat blocks[Shape::CORNERS * (Shape::CORNERS + 1) / 2]; ///< k <= l
};

/// Adds the energy of curvature at one point, and up to ORDER its derivatives: by the point's turn (point), by the
/// corners' quaternions (sums), and both at once (sums).
template <class Shape, Order ORDER>
WRY_INLINE void add_point_curvature(const MixedBatch& batch, int lane, int p, Real weight,
                                    const CurvedElement<Shape>& element, Point& point, Real& energy,
                                    RotationSums<Shape>& sums) {
  constexpr int DIM = Shape::DIM, CORNERS = Shape::CORNERS;
  Quat q0 = load_quat(batch.point_rotations + 4 * p * LANES + lane);
  if (element.turned)
    q0 = q0 * element.frame;
  const Quat q = sqrt(point.inverse) * (q0 + point.half * q0);
  const Quat back = conjugate(q);
  Vec rest[3] = {};
  if (batch.rest_curvature != nullptr)
    load_rest(batch, lane, p, element.turned ? &element.axes : nullptr, rest);
  Quat relative[CORNERS];
  for (int k = 0; k < CORNERS; ++k)
    relative[k] = back * element.nodal.q[k];
  Real c[DIM];
  Vec u[DIM], excess[DIM], stress[DIM];
  for (int j = 0; j < DIM; ++j) {
    Quat sum = component(element.gradients[0], j) * relative[0];
    for (int k = 1; k < CORNERS; ++k)
      sum = sum + component(element.gradients[k], j) * relative[k];
    c[j] = sum.w;
    u[j] = vector_part(sum);
    excess[j] = broadcast(2.0) * u[j] - rest[j];
  }
  element.law.stress(excess, stress);
  Real work{};
  Vec torque{};
  for (int j = 0; j < DIM; ++j) {
    stress[j] = weight * stress[j];
    energy += 0.5 * dot(stress[j], excess[j]);
    if constexpr (ORDER != Order::energy) {
      torque = torque - (c[j] * stress[j] + cross(u[j], stress[j]));
      work += dot(stress[j], u[j]);
    }
  }
  if constexpr (ORDER == Order::energy)
    return;
  const Mat R = scaled_rotation(q);
  point.torque = point.torque + R * torque;
  Vec pull[CORNERS]; // stress times g_k
  for (int k = 0; k < CORNERS; ++k) {
    pull[k] = component(element.gradients[k], 0) * stress[0];
    for (int j = 1; j < DIM; ++j)
      pull[k] = pull[k] + component(element.gradients[k], j) * stress[j];
    sums.by_q[k] = sums.by_q[k] + broadcast(2.0) * (q * pull[k]);
  }
  if constexpr (ORDER == Order::gradient)
    return;

  // By the turn twice: sum of Z^T C Z, a column of Z at a time.
  Vec columns[3];
  for (int i = 0; i < 3; ++i) {
    Vec delta[DIM], response[DIM];
    for (int j = 0; j < DIM; ++j) {
      // Z_j e_i = c_j e_i - u_j x e_i
      const Vec axis = {broadcast(i == 0 ? 1.0 : 0.0), broadcast(i == 1 ? 1.0 : 0.0), broadcast(i == 2 ? 1.0 : 0.0)};
      delta[j] = c[j] * axis - cross(u[j], axis);
    }
    element.law.stress(delta, response);
    columns[i] = Vec{};
    for (int j = 0; j < DIM; ++j)
      columns[i] = columns[i] + weight * (c[j] * response[j] + cross(u[j], response[j]));
  }
  const Mat body = transposed(Mat{columns[0], columns[1], columns[2]});
  point.K = point.K + plus_identity(symmetric_part(R * body * transposed(R)), -0.5 * work);

  // By the corners' quaternions, along the derivative of each by its increment.
  const Mat chain = transposed(times_D(transposed(R), point)); // D^T R
  const double near = Shape::NEAR, far = Shape::FAR;
  for (int k = 0; k < CORNERS; ++k) {
    Vec mixed[3], turns[CORNERS][3];
    for (int i = 0; i < 3; ++i) {
      const Quat step = back * element.nodal.derivative[k][i];
      const Vec v = broadcast(2.0 * 1.0) * vector_part(step);
      Vec delta[DIM], response[DIM];
      for (int j = 0; j < DIM; ++j)
        delta[j] = component(element.gradients[k], j) * v;
      element.law.stress(delta, response);
      mixed[i] = -(step.w * pull[k] + cross(vector_part(step), pull[k]));
      for (int j = 0; j < DIM; ++j) {
        response[j] = weight * response[j];
        mixed[i] = mixed[i] - (c[j] * response[j] + cross(u[j], response[j]));
      }
      for (int l = k; l < CORNERS; ++l) {
        Vec along = component(element.gradients[l], 0) * response[0];
        for (int j = 1; j < DIM; ++j)
          along = along + component(element.gradients[l], j) * response[j];
        turns[l][i] = along;
      }
      mixed[i] = chain * mixed[i];
    }
    const Mat by_turn = transposed(Mat{mixed[0], mixed[1], mixed[2]}); // d2E / da_point da_k
    for (int l = 0; l < CORNERS; ++l) {
      const Mat share = broadcast(l == p ? near : far) * by_turn;
      if (l < k)
        sums.blocks[upper_block(l, k, CORNERS)] = sums.blocks[upper_block(l, k, CORNERS)] + share;
      else if (l > k)
        sums.blocks[upper_block(k, l, CORNERS)] = sums.blocks[upper_block(k, l, CORNERS)] + transposed(share);
      else
        sums.blocks[upper_block(k, k, CORNERS)] =
            sums.blocks[upper_block(k, k, CORNERS)] + full(broadcast(2.0) * symmetric_part(share));
    }
    for (int l = k; l < CORNERS; ++l) {
      Mat block;
      const auto row = [&](const Vec& turn) {
        const auto entry = [&](int i) { return 2.0 * dot(vector_part(back * element.nodal.derivative[l][i]), turn); };
        return Vec{entry(0), entry(1), entry(2)};
      };
      block = {row(turns[l][0]), row(turns[l][1]), row(turns[l][2])};
      sums.blocks[upper_block(k, l, CORNERS)] = sums.blocks[upper_block(k, l, CORNERS)] + block;
    }
  }
}

/// From the corners' quaternions to their increments, once all points are summed.
template <class Shape, Order ORDER>
WRY_INLINE void chain_corners(const CurvedElement<Shape>& element, RotationSums<Shape>& sums) {
  for (int k = 0; k < Shape::CORNERS; ++k) {
    const Quat(&derivative)[3] = element.nodal.derivative[k];
    const Quat& g = sums.by_q[k];
    const Vec tau = {dot(derivative[0], g), dot(derivative[1], g), dot(derivative[2], g)};
    sums.gradient[k] = sums.gradient[k] + tau;
    if constexpr (ORDER == Order::hessian) {
      Mat& block = sums.blocks[upper_block(k, k, Shape::CORNERS)];
      block = block + full(quaternion_curvature(element.nodal, k, g, tau));
    }
  }
}

} // namespace wry::fem::WRY_ISA
