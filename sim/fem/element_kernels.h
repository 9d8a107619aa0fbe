#pragma once

#include <cstdint>

#include "sim/base/aligned.h"
#include "sim/base/isa.h"
#include "sim/fem/fem_plan.h"
#include "sim/fem/kernels/batch.h"

namespace wry::fem {

/// Elements that share one energy, in batches of LANES, lanes innermost: entry (batch, i, lane) of an array with n
/// entries per element stands at (batch * n + i) * LANES + lane. The last batch is padded with elements of volume 0.
struct ElementGroup {
  ElasticModel model = ElasticModel::neo_hookean;
  CurvatureModel curvature = CurvatureModel::none;
  bool couple_equals_shear = true; ///< mu_c == mu in every element
  int element_count = 0;
  int batch_count = 0;
  AlignedVector<std::int32_t> nodes;      ///< 4 per element, ascending; global node numbers
  AlignedVector<double> shape_gradients;  ///< 9: d phi_k / d X_j for k = 1..3 (row k-1); node 0 is minus their sum
  AlignedVector<double> volume;           ///< 1 [m^3]
  AlignedVector<double> mu, lambda, mu_c; ///< 1 each [Pa]
  /// isotropic: 3: mu L_c^2 times alpha, beta, gamma. orthotropic: 9: mu L_c^2 C_ij. none: empty.
  AlignedVector<double> curvature_moduli;
  AlignedVector<double> curvature_basis; ///< 9: B row-major, columns are the axes; empty: identity
  AlignedVector<double> rest_curvature;  ///< 4 x 9: Gamma0 at each point, row-major; empty: zero
  /// 4 x 4: the stored rotation q0 of each point (w, x, y, z). Empty for classic models.
  AlignedVector<double> point_rotations;

  int dofs_per_node() const { return is_micropolar(model) ? 6 : 3; }
};

/// The functions of one energy for one instruction set. Energies are +infinity where a log-barrier model is inverted.
struct ElementKernel {
  /// energy[LANES]
  void (*energy)(const ElementGroup&, const NodeFields&, int batch, double* energy) = nullptr;
  /// energy and gradient
  void (*gradient)(const ElementGroup&, const NodeFields&, int batch, BatchDerivatives&) = nullptr;
  /// energy, gradient and the exact (not projected) Hessian
  void (*hessian)(const ElementGroup&, const NodeFields&, int batch, BatchDerivatives&) = nullptr;
  /// After convergence: point_rotations <- cay(a interpolated) point_rotations. nullptr for classic models.
  void (*advance_rotations)(ElementGroup&, const NodeFields&, int batch) = nullptr;
};

/// The kernel for a group's model, curvature and flags.
ElementKernel select_kernel(const ElementGroup& group, Isa isa);

/// Packs tets into a group. Nodes are numbered mesh vertex + node_offset; elements keep their order; the corners of an
/// element are sorted ascending. Point rotations start at identity, rest curvature empty.
/// Errors: bad_input naming the tet whose volume is not positive and finite.
Result<ElementGroup> build_element_group(const geometry::TetMesh& mesh, const FemMaterial& material, int node_offset);

} // namespace wry::fem
