#pragma once

#include <cstdint>

#include "sim/fem/kernels/batch.h"

namespace wry::fem {

/// Energies of curvature of elements with their own numbers of nodes for positions and for rotations.
enum class MixedCurvature {
  none,
  isotropic,   ///< 3 moduli: 1/2 (a |sym|^2 + b |skew|^2 + c tr^2) of Gamma
  orthotropic, ///< 9 moduli: sum C_ij Gamma_ij^2
  plate        ///< 3 moduli: 1/2 (a |sym K|^2 + b |skew K|^2 + c tr(K)^2), K_.j = Gamma_.j x normal
};

/// One batch of elements of NX nodes with positions, of which the first NR carry rotations; arrays of lanes innermost,
/// from this batch's first lane on.
struct MixedBatch {
  MixedCurvature curvature = MixedCurvature::none;
  bool couple_equals_shear = false;
  const std::int32_t* nodes = nullptr;     ///< NX: corners, then midpoints of their edges 01 02 [03] 12 [13 23]
  const double* gradients = nullptr;       ///< 3 (NR - 1): of the linear functions of corners 1 .. NR - 1
  const double* volume = nullptr;          ///< of plates: area times thickness
  const double* mu = nullptr;              ///< [Pa]
  const double* lambda = nullptr;          ///< [Pa]; of plates: 2 mu lambda / (2 mu + lambda)
  const double* mu_c = nullptr;            ///< [Pa]
  const double* moduli = nullptr;          ///< of curvature, see MixedCurvature
  const double* frame = nullptr;           ///< 4: the rotation from axes to the rest shape; nullptr: identity
  const double* rest_curvature = nullptr;  ///< NP x 9: Gamma0, nullptr: zero
  const double* point_rotations = nullptr; ///< NP x 4
  /// Plates: 2, the greatest squared stretch that is free, and the modulus beyond [Pa]; nullptr: no limit.
  const double* stretch_limit = nullptr;
};

/// Blocks of 3 x 3 entries, row-major, lanes innermost. Positions are blocks 0 .. NX - 1, rotations follow.
inline constexpr int MIXED_NODES = 10, MIXED_CORNERS = 4, MIXED_POINTS = 4;
struct alignas(64) MixedDerivatives {
  double energy[LANES];
  double gradient[3 * (MIXED_NODES + MIXED_CORNERS) * LANES];
  double xx[9 * MIXED_NODES * (MIXED_NODES + 1) / 2 * LANES]; ///< k <= l: 00 01 .. 11 ..
  double xa[9 * MIXED_NODES * MIXED_CORNERS * LANES];         ///< (k, l) at NR k + l
  double aa[9 * MIXED_CORNERS * (MIXED_CORNERS + 1) / 2 * LANES];
};

/// Number of block (k, l), k <= l, among the upper blocks of `count` nodes.
[[gnu::always_inline]] inline constexpr int upper_block(int k, int l, int count) {
  return k * (2 * count - k - 1) / 2 + l;
}

using EvaluateMixed = void (*)(const MixedBatch&, const NodeFields&, MixedDerivatives&);

/// An element in one instruction set.
struct MixedKernel {
  int nodes = 0;   ///< NX
  int corners = 0; ///< NR
  int points = 0;  ///< NP
  bool plate = false;
  EvaluateMixed energy = nullptr;
  EvaluateMixed gradient = nullptr;
  EvaluateMixed hessian = nullptr;
  /// point_rotations <- cay(a interpolated) point_rotations
  void (*advance)(const MixedBatch&, const NodeFields&, double* point_rotations) = nullptr;
};

} // namespace wry::fem
