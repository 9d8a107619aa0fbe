#pragma once

#include <cstdint>

namespace wry::fem {

/// Elements of a batch, whatever the instruction set: all arrays of a group are laid out in runs of this many lanes.
inline constexpr int LANES = 8;
/// Quadrature points of a tet; point p lies near node p (spec §3).
inline constexpr int POINTS = 4;

/// Fields on all nodes of the simulation.
struct NodeFields {
  const double* positions = nullptr;           ///< nodes x 3: trial x [m]
  const double* rotation_increments = nullptr; ///< nodes x 3: a = dt omega; ignored for classic models
  const double* rotations = nullptr;           ///< nodes x 4: stored q0 (w, x, y, z); ignored for classic models
};

/// What one batch evaluates to: derivatives with respect to x and a (the caller multiplies by dt for v and omega).
/// With d = dofs_per_node(): gradient[(node * d + i)][lane], node-major [x0 a0 x1 a1 ...].
/// hessian: upper blocks (k <= l) in the order 00 01 02 03 11 12 13 22 23 33, each d x d row-major and complete.
struct alignas(64) BatchDerivatives {
  double energy[LANES];
  double gradient[24 * LANES];
  double hessian[10 * 36 * LANES];
};

/// How many derivatives an evaluation fills.
enum class Order { energy, gradient, hessian };

/// Curvature energies, as CurvatureModel in the plan.
enum class BatchCurvature { none, isotropic, orthotropic };

/// One batch of an ElementGroup for the kernel files: the arrays described there, from this batch's first lane on.
struct Batch {
  BatchCurvature curvature = BatchCurvature::none;
  bool couple_equals_shear = false;
  const std::int32_t* nodes = nullptr;
  const double* shape_gradients = nullptr;
  const double* volume = nullptr;
  const double* mu = nullptr;
  const double* lambda = nullptr;
  const double* mu_c = nullptr;
  const double* curvature_moduli = nullptr;
  const double* curvature_basis = nullptr; ///< nullptr: identity
  const double* rest_curvature = nullptr;  ///< nullptr: zero
  const double* point_rotations = nullptr;
};

/// Evaluates a batch. Arrays as in BatchDerivatives; those that the function's order does not ask for may be nullptr.
using EvaluateBatch = void (*)(const Batch&, const NodeFields&, double* energy, double* gradient, double* hessian);

/// A model in one instruction set.
struct ModelKernel {
  EvaluateBatch energy = nullptr;
  EvaluateBatch gradient = nullptr;
  EvaluateBatch hessian = nullptr;
};

/// point_rotations <- cay(a interpolated) point_rotations, for one batch.
using AdvanceRotations = void (*)(const Batch&, const NodeFields&, double* point_rotations);

} // namespace wry::fem
