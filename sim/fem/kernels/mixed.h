#pragma once

#include "sim/fem/kernels/mixed_curvature.h"

/// Evaluation of elements whose positions may have other shape functions than their rotations (mixed_shape.h).
namespace wry::fem::WRY_ISA {

template <class Shape> struct MixedElement {
  static constexpr int FREE = Shape::CORNERS - 1;
  Vec positions[NODES<Shape>];
  Vec gradients[FREE];
  Vec normal, first, second; ///< of plates
  Real volume;
  PointModuli moduli; ///< times the weight of a point
};

template <class Shape>
WRY_INLINE MixedElement<Shape> load_mixed(const MixedBatch& batch, const NodeFields& fields, int lane) {
  MixedElement<Shape> element;
  for (int k = 0; k < NODES<Shape>; ++k)
    element.positions[k] = gather_vec(fields.positions, batch.nodes + k * LANES + lane);
  for (int k = 0; k < MixedElement<Shape>::FREE; ++k)
    element.gradients[k] = load_vec(batch.gradients + 3 * k * LANES + lane);
  element.volume = load(batch.volume + lane);
  const Real weight = (1.0 / Shape::POINTS) * element.volume;
  const Real mu = load(batch.mu + lane);
  element.moduli = {weight * mu, weight * load(batch.lambda + lane), weight * (mu - load(batch.mu_c + lane))};
  if constexpr (Shape::DIM == 2) {
    const Mat axes = scaled_rotation(load_quat(batch.frame + lane));
    element.first = {axes.r0.x, axes.r1.x, axes.r2.x};
    element.second = {axes.r0.y, axes.r1.y, axes.r2.y};
    element.normal = {axes.r0.z, axes.r1.z, axes.r2.z};
  }
  return element;
}

template <class Shape> WRY_INLINE Point load_point(const MixedBatch& batch, const NodeFields& fields, int lane, int p) {
  Vec increment{};
  for (int k = 0; k < Shape::CORNERS; ++k)
    increment = increment + broadcast(barycentric<Shape>(k, p)) *
                                gather_vec(fields.rotation_increments, batch.nodes + k * LANES + lane);
  Point point;
  point.half = broadcast(0.5) * increment;
  point.inverse = 1.0 / (1.0 + dot(point.half, point.half));
  const Quat q0 = load_quat(batch.point_rotations + 4 * p * LANES + lane);
  point.R = point.inverse * scaled_rotation(q0 + point.half * q0);
  point.torque = Vec{};
  point.K = Sym{};
  return point;
}

/// The places of the corners as a point sees them, relative to corner 0.
template <class Shape>
WRY_INLINE void place_corners(const MixedElement<Shape>& element, int p, PointStretch<Shape>& at) {
  const auto& share = SHARES<Shape>.share[p];
  Vec places[Shape::CORNERS];
  unroll<Shape::CORNERS>([&](auto i) {
    places[i] = Vec{};
    unroll<NODES<Shape>>([&](auto k) {
      if constexpr (has_share<Shape>(k, i))
        places[i] = places[i] + broadcast(share[k][i]) * element.positions[k];
    });
  });
  for (int k = 0; k < PointStretch<Shape>::FREE; ++k) {
    at.edges[k] = places[k + 1] - places[0];
    at.force[k] = Vec{};
  }
  at.energy = Real{};
  for (Mat& block : at.blocks)
    block = Mat{};
}

template <class Shape> struct NodeSums {
  static constexpr int COUNT = NODES<Shape>;
  Vec force[COUNT];
  Mat xx[COUNT * (COUNT + 1) / 2];
  Mat xa[COUNT * Shape::CORNERS];
};

/// Blocks (i, l) of corners, corner 0 being minus the sum of the others.
template <class Shape>
WRY_INLINE void complete_blocks(const PointStretch<Shape>& at, Mat (&blocks)[Shape::CORNERS][Shape::CORNERS]) {
  constexpr int FREE = PointStretch<Shape>::FREE;
  int i = 0;
  for (int k = 0; k < FREE; ++k) {
    for (int l = k; l < FREE; ++l, ++i) {
      blocks[k + 1][l + 1] = at.blocks[i];
      blocks[l + 1][k + 1] = transposed(at.blocks[i]);
    }
  }
  blocks[0][0] = Mat{};
  for (int l = 1; l <= FREE; ++l) {
    Mat sum = blocks[1][l];
    for (int k = 2; k <= FREE; ++k)
      sum = sum + blocks[k][l];
    blocks[0][l] = -sum;
    blocks[l][0] = transposed(blocks[0][l]);
    blocks[0][0] = blocks[0][0] - blocks[0][l];
  }
}

/// What a point's derivatives by places and its increment are by the nodes.
template <class Shape, Order ORDER>
WRY_INLINE void spread_point(const PointStretch<Shape>& at, const Point& point, int p, NodeSums<Shape>& sums) {
  constexpr int CORNERS = Shape::CORNERS, FREE = CORNERS - 1;
  Vec force[CORNERS];
  force[0] = Vec{};
  for (int k = 0; k < FREE; ++k) {
    force[k + 1] = at.force[k];
    force[0] = force[0] - at.force[k];
  }
  const auto& share = SHARES<Shape>.share[p];
  unroll<NODES<Shape>>([&](auto k) {
    unroll<CORNERS>([&](auto i) {
      if constexpr (has_share<Shape>(k, i))
        sums.force[k] = sums.force[k] + broadcast(share[k][i]) * force[i];
    });
  });
  if constexpr (ORDER != Order::hessian)
    return;
  Mat blocks[CORNERS][CORNERS];
  complete_blocks(at, blocks);
  Mat mixed[CORNERS];
  mixed[0] = Mat{};
  for (int k = 0; k < FREE; ++k) {
    mixed[k + 1] = point.mixed[k];
    mixed[0] = mixed[0] - point.mixed[k];
  }
  unroll<NODES<Shape>>([&](auto k) {
    Mat rows[CORNERS] = {}; // sum over i of the share of (k, i) times block (i, j)
    Mat turn{};
    unroll<CORNERS>([&](auto i) {
      if constexpr (has_share<Shape>(k, i)) {
        for (int j = 0; j < CORNERS; ++j)
          rows[j] = rows[j] + broadcast(share[k][i]) * blocks[i][j];
        turn = turn + broadcast(share[k][i]) * mixed[i];
      }
    });
    unroll<NODES<Shape> - k>([&](auto offset) {
      constexpr int l = k + offset;
      Mat& to = sums.xx[upper_block(k, l, NODES<Shape>)];
      unroll<CORNERS>([&](auto j) {
        if constexpr (has_share<Shape>(l, j))
          to = to + broadcast(share[l][j]) * rows[j];
      });
    });
    for (int l = 0; l < CORNERS; ++l)
      sums.xa[k * CORNERS + l] = sums.xa[k * CORNERS + l] + broadcast(barycentric<Shape>(l, p)) * turn;
  });
}

/// Adds the derivatives by the corners' increments through the rotation of a point (points.h).
template <class Shape, Order ORDER>
WRY_INLINE void spread_rotation(const Point& point, int p, RotationSums<Shape>& sums) {
  const Vec tau = D_transposed_times(point, point.torque);
  for (int k = 0; k < Shape::CORNERS; ++k)
    sums.gradient[k] = sums.gradient[k] + broadcast(barycentric<Shape>(k, p)) * tau;
  if constexpr (ORDER != Order::hessian)
    return;
  const Mat KD = times_D(full(point.K), point);
  const Mat turned = KD - cross(point.half, KD);
  const Sym DKD = {turned.r0.x, turned.r0.y, turned.r0.z, turned.r1.y, turned.r1.z, turned.r2.z};
  const Mat second = full(point.inverse * (DKD - symmetric_outer(broadcast(0.5) * point.half, tau)));
  for (int k = 0; k < Shape::CORNERS; ++k) {
    for (int l = k; l < Shape::CORNERS; ++l) {
      Mat& to = sums.blocks[upper_block(k, l, Shape::CORNERS)];
      to = to + broadcast(barycentric<Shape>(k, p) * barycentric<Shape>(l, p)) * second;
    }
  }
}

template <class Shape, Order ORDER>
WRY_INLINE void store_mixed(const NodeSums<Shape>& nodes, const RotationSums<Shape>& rotations, int lane,
                            MixedDerivatives& out) {
  if constexpr (ORDER == Order::energy)
    return;
  for (int k = 0; k < NODES<Shape>; ++k)
    store_vec(out.gradient + 3 * k * LANES + lane, nodes.force[k]);
  for (int k = 0; k < Shape::CORNERS; ++k)
    store_vec(out.gradient + 3 * (NODES<Shape> + k) * LANES + lane, rotations.gradient[k]);
  if constexpr (ORDER != Order::hessian)
    return;
  const auto store_all = [lane](double* to, const Mat* blocks, int count) {
    for (int i = 0; i < count; ++i)
      store_block(to + 9 * i * LANES + lane, 3, blocks[i]);
  };
  store_all(out.xx, nodes.xx, NODES<Shape> * (NODES<Shape> + 1) / 2);
  store_all(out.xa, nodes.xa, NODES<Shape> * Shape::CORNERS);
  store_all(out.aa, rotations.blocks, Shape::CORNERS * (Shape::CORNERS + 1) / 2);
}

template <class Shape, bool COUPLE, bool CURVED, Order ORDER>
void evaluate_mixed_batch(const MixedBatch& batch, const NodeFields& fields, MixedDerivatives& out) {
  for (int lane = 0; lane < LANES; lane += WIDTH) {
    const MixedElement<Shape> element = load_mixed<Shape>(batch, fields, lane);
    CurvedElement<Shape> curved;
    if constexpr (CURVED)
      load_curved<Shape, ORDER>(batch, fields, lane, element.gradients, curved);
    NodeSums<Shape> nodes{};
    RotationSums<Shape> rotations{};
    Real energy{};
    for (int p = 0; p < Shape::POINTS; ++p) {
      Point point = load_point<Shape>(batch, fields, lane, p);
      PointStretch<Shape> at;
      place_corners(element, p, at);
      const Mat F = gradient_of(at, element.gradients);
      add_point_strain<Shape, COUPLE, ORDER>(F, element.gradients, element.normal, element.moduli, point, at);
      if constexpr (Shape::DIM == 2) {
        if (batch.stretch_limit != nullptr)
          add_stretch_limit<Shape, ORDER>(
              F, element.gradients, element.first, element.second, load(batch.stretch_limit + lane),
              (1.0 / Shape::POINTS) * element.volume * load(batch.stretch_limit + LANES + lane), at);
      }
      energy += at.energy;
      if constexpr (CURVED)
        add_point_curvature<Shape, ORDER>(batch, lane, p, (1.0 / Shape::POINTS) * element.volume, curved, point, energy,
                                          rotations);
      if constexpr (ORDER != Order::energy) {
        spread_point<Shape, ORDER>(at, point, p, nodes);
        spread_rotation<Shape, ORDER>(point, p, rotations);
      }
    }
    if constexpr (CURVED && ORDER != Order::energy)
      chain_corners<Shape, ORDER>(curved, rotations);
    store(out.energy + lane, element.volume > 0.0 ? energy : Real{});
    store_mixed<Shape, ORDER>(nodes, rotations, lane, out);
  }
}

template <class Shape, Order ORDER>
void evaluate_mixed(const MixedBatch& batch, const NodeFields& fields, MixedDerivatives& out) {
  const bool curved = batch.curvature != MixedCurvature::none;
  if (batch.couple_equals_shear)
    (curved ? evaluate_mixed_batch<Shape, false, true, ORDER>
            : evaluate_mixed_batch<Shape, false, false, ORDER>)(batch, fields, out);
  else
    (curved ? evaluate_mixed_batch<Shape, true, true, ORDER>
            : evaluate_mixed_batch<Shape, true, false, ORDER>)(batch, fields, out);
}

template <class Shape> void advance_mixed(const MixedBatch& batch, const NodeFields& fields, double* point_rotations) {
  for (int lane = 0; lane < LANES; lane += WIDTH) {
    for (int p = 0; p < Shape::POINTS; ++p) {
      Vec increment{};
      for (int k = 0; k < Shape::CORNERS; ++k)
        increment = increment + broadcast(barycentric<Shape>(k, p)) *
                                    gather_vec(fields.rotation_increments, batch.nodes + k * LANES + lane);
      double* to = point_rotations + 4 * p * LANES + lane;
      const Quat q0 = load_quat(to);
      const Quat q = q0 + (broadcast(0.5) * increment) * q0;
      const Quat unit = (1.0 / sqrt(dot(q, q))) * q;
      store(to, unit.w);
      store(to + LANES, unit.x);
      store(to + 2 * LANES, unit.y);
      store(to + 3 * LANES, unit.z);
    }
  }
}

template <class Shape> constexpr MixedKernel mixed_kernel() {
  return {NODES<Shape>,
          Shape::CORNERS,
          Shape::POINTS,
          Shape::DIM == 2,
          evaluate_mixed<Shape, Order::energy>,
          evaluate_mixed<Shape, Order::gradient>,
          evaluate_mixed<Shape, Order::hessian>,
          advance_mixed<Shape>};
}

} // namespace wry::fem::WRY_ISA
