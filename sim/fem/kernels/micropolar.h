#pragma once

#include "sim/fem/kernels/compressible.h"
#include "sim/fem/kernels/curvature.h"
#include "sim/fem/kernels/points.h"

/// The strain energy of micropolar models in the world frame: V = F R^T and W = V - I have the invariants of the spec's
/// U = R^T F and E = U - I, and a turn of R by theta changes them by delta V = -V cross(theta). With z = 2 axl skew W
/// and b_k = R grad phi_k the derivatives need no fourth-order tensors.
namespace wry::fem::WRY_ISA {

/// Moduli of mu |W|^2 + lambda/2 tr(W)^2 - couple/2 |z|^2, times the weight of a point. |skew W|^2 is |z|^2 / 2, so
/// that couple = mu - mu_c gives mu |sym W|^2 + mu_c |skew W|^2.
struct StrainModuli {
  Real mu, lambda, couple;
};

/// Adds the strain energy of the points, and up to ORDER its derivatives by positions (part) and rotations (points).
/// Terms::COUPLE is false where couple is zero, Terms::STRETCH where mu and lambda are.
template <class Terms, Order ORDER>
WRY_INLINE void add_strain(const Element& element, const StrainModuli& moduli, Points& points, PositionPart& part) {
  const Mat F = deformation_gradient(element);
  const Sym left_cauchy_green = square(F);
  Vec force[3] = {};
  Mat sums[6] = {}; // of b_k b_l^T
  Real energy = {};
  for (int p = 0; p < POINTS; ++p) {
    Point& point = points.point[p];
    const Mat V = F * transposed(point.R);
    const Mat W = plus_identity(V, broadcast(-1.0));
    const Vec z = axial(V);
    const Real tr = trace(W);
    if constexpr (Terms::STRETCH)
      energy += moduli.mu * (dot(W.r0, W.r0) + dot(W.r1, W.r1) + dot(W.r2, W.r2)) + 0.5 * moduli.lambda * tr * tr;
    if constexpr (Terms::COUPLE)
      energy -= 0.5 * moduli.couple * dot(z, z);
    if constexpr (ORDER == Order::energy)
      continue;

    const Sym A = symmetric_part(V);
    const Real trace_A = tr + 3.0;
    const Real s = Terms::STRETCH ? moduli.lambda * tr - 2.0 * moduli.mu : Real{};
    const Vec b[3] = {point.R * element.gradients[0], point.R * element.gradients[1], point.R * element.gradients[2]};
    point.torque = s * z;
    if constexpr (Terms::COUPLE)
      point.torque = point.torque + moduli.couple * (trace_A * z - A * z);
    for (int k = 0; k < 3; ++k) {
      force[k] = force[k] + s * b[k];
      if constexpr (Terms::COUPLE)
        force[k] = force[k] - cross(moduli.couple * z, b[k]);
    }
    if constexpr (ORDER == Order::gradient)
      continue;

    // K = s (A - tr A I) + lambda z z^T - couple (Y^T Y - sym(cross(z) V) - |z|^2 I), where delta z = -Y theta
    Sym K = plus_identity(s * A, -s * trace_A);
    if constexpr (Terms::STRETCH)
      K = K + square_scaled(moduli.lambda, z);
    const Mat Y = plus_identity(-transposed(V), trace_A);
    if constexpr (Terms::COUPLE) {
      const Sym YtY = plus_identity(left_cauchy_green - 2.0 * trace_A * A, trace_A * trace_A);
      const Sym second = plus_identity(YtY - symmetric_part(cross(z, V)), -dot(z, z));
      K = K - moduli.couple * second;
    }
    point.K = K;

    // d(dE/dx_k)/d theta = lambda b_k z^T - s cross(b_k) - couple (cross(b_k) Y + (z.b_k) I - b_k z^T), times D
    const Vec zeta = D_transposed_times(point, z);
    if constexpr (Terms::COUPLE) {
      const Mat G = times_D(plus_identity(moduli.couple * Y, s), point);
      const Mat D = D_matrix(point);
      for (int k = 0; k < 3; ++k) {
        const Real along = moduli.couple * dot(z, b[k]);
        point.mixed[k] = outer((moduli.lambda + moduli.couple) * b[k], zeta) - cross(b[k], G) - along * D;
      }
    } else {
      const Vec scaled_zeta = moduli.lambda * zeta;
      const Vec turn = (s * point.inverse) * point.half;
      const Real scale = s * point.inverse;
      for (int k = 0; k < 3; ++k) {
        // cross(b) D = (cross(b) + half b^T - (half.b) I) / n^2
        const Mat m = plus_identity(outer(b[k], scaled_zeta) - outer(turn, b[k]), dot(turn, b[k]));
        point.mixed[k] = minus_cross(m, scale * b[k]);
      }
    }
    sums[0] = sums[0] + outer(b[0], b[0]);
    sums[1] = sums[1] + outer(b[0], b[1]);
    sums[2] = sums[2] + outer(b[0], b[2]);
    sums[3] = sums[3] + outer(b[1], b[1]);
    sums[4] = sums[4] + outer(b[1], b[2]);
    sums[5] = sums[5] + outer(b[2], b[2]);
  }
  part.energy += energy;
  if constexpr (ORDER == Order::energy)
    return;
  for (int k = 0; k < 3; ++k) {
    part.force[k] = part.force[k] + force[k];
    if constexpr (Terms::STRETCH)
      part.force[k] = part.force[k] + (8.0 * moduli.mu) * (F * element.gradients[k]);
  }
  if constexpr (ORDER == Order::gradient)
    return;
  int i = 0;
  for (int k = 0; k < 3; ++k) {
    for (int l = k; l < 3; ++l, ++i) {
      const Real metric = dot(element.gradients[k], element.gradients[l]);
      Mat block = moduli.lambda * sums[i];
      Real diagonal = 8.0 * moduli.mu * metric;
      if constexpr (Terms::COUPLE) {
        block = block + moduli.couple * transposed(sums[i]);
        diagonal -= 4.0 * moduli.couple * metric;
      }
      part.blocks[i] = part.blocks[i] + plus_identity(block, diagonal);
    }
  }
}

/// What a pack of elements carries from stage to stage.
struct Work {
  Element element;
  Points points;
  PositionPart part;
};

template <class Model, Order ORDER>
WRY_INLINE void strain_stage(const Batch& batch, const NodeFields& fields, int lane, Work& work) {
  work.element = load_element(batch, fields, lane);
  load_points(batch, fields, lane, work.points);
  work.part = PositionPart{};
  Model::template add<ORDER>(work.element, work.points, work.part);
}

template <Order ORDER, Writing WRITING>
WRY_INLINE void store_stage(const Work& work, int lane, double* gradient, double* hessian) {
  if constexpr (ORDER == Order::energy)
    return;
  store_forces(gradient + lane, 6, work.part.force);
  if constexpr (ORDER == Order::hessian) {
    store_position_blocks(hessian + lane, 6, work.part.blocks);
    store_mixed_blocks(hessian + lane, work.points);
    write_rotation_derivatives<ORDER, WRITING>(gradient + lane, hessian + lane, work.points);
  } else {
    write_rotation_derivatives<ORDER, WRITING>(gradient + lane, nullptr, work.points);
  }
}

template <class Model, Order ORDER>
void evaluate_plain(const Batch& batch, const NodeFields& fields, double* energy, double* gradient, double* hessian) {
  for (int lane = 0; lane < LANES; lane += WIDTH) {
    Work work;
    strain_stage<Model, ORDER>(batch, fields, lane, work);
    store(energy + lane, work.part.energy);
    store_stage<ORDER, Writing::store>(work, lane, gradient, hessian);
  }
}

/// Each stage runs over the whole batch before the next one starts: together their code is larger than a core's
/// instruction cache.
template <class Model, Order ORDER>
void evaluate_curved(const Batch& batch, const NodeFields& fields, double* energy, double* gradient, double* hessian) {
  Work all[LANES / WIDTH];
  for (int lane = 0; lane < LANES; lane += WIDTH)
    strain_stage<Model, ORDER>(batch, fields, lane, all[lane / WIDTH]);
  for (int lane = 0; lane < LANES; lane += WIDTH) {
    Work& work = all[lane / WIDTH];
    double* const slopes = ORDER == Order::energy ? nullptr : gradient + lane;
    double* const curves = ORDER == Order::hessian ? hessian + lane : nullptr;
    if (batch.curvature == BatchCurvature::isotropic)
      add_isotropic_curvature<ORDER>(batch, fields, lane, work.element, work.points, work.part.energy, slopes, curves);
    else
      add_orthotropic_curvature<ORDER>(batch, fields, lane, work.element, work.points, work.part.energy, slopes,
                                       curves);
    store(energy + lane, work.part.energy);
  }
  for (int lane = 0; lane < LANES; lane += WIDTH)
    store_stage<ORDER, Writing::add>(all[lane / WIDTH], lane, gradient, hessian);
}

/// Evaluates a batch. Model::add<ORDER>(element, points, part) adds the strain energy, times the volume.
template <class Model, Order ORDER>
void evaluate_micropolar(const Batch& batch, const NodeFields& fields, double* energy, double* gradient,
                         double* hessian) {
  if (batch.curvature == BatchCurvature::none)
    evaluate_plain<Model, ORDER>(batch, fields, energy, gradient, hessian);
  else
    evaluate_curved<Model, ORDER>(batch, fields, energy, gradient, hessian);
}

template <class Model> constexpr ModelKernel micropolar_kernel() {
  return {evaluate_micropolar<Model, Order::energy>, evaluate_micropolar<Model, Order::gradient>,
          evaluate_micropolar<Model, Order::hessian>};
}

} // namespace wry::fem::WRY_ISA
