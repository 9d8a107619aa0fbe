#pragma once

#include <cstdint>
#include <vector>

#include "sim/base/aligned.h"
#include "sim/base/result.h"
#include "sim/fem/fem_plan.h"
#include "sim/fem/kernels/mixed_batch.h"

namespace wry::fem {

/// Elements of one body that have a mixed kernel, in batches of LANES, lanes innermost (as ElementGroup). The last
/// batch is padded with elements of volume 0.
struct MixedGroup {
  const MixedKernel* kernel = nullptr;
  MixedCurvature curvature = MixedCurvature::none;
  bool couple_equals_shear = true;
  int element_count = 0;
  int batch_count = 0;
  AlignedVector<std::int32_t> nodes;      ///< NX per element, see MixedBatch; global node numbers
  AlignedVector<double> gradients;        ///< 3 (NR - 1)
  AlignedVector<double> volume;           ///< [m^3]
  AlignedVector<double> mu, lambda, mu_c; ///< [Pa]
  AlignedVector<double> moduli;           ///< 3 or 9
  AlignedVector<double> frame;            ///< 4; empty: identity
  AlignedVector<double> rest_curvature;   ///< NP x 9; empty: zero
  AlignedVector<double> point_rotations;  ///< NP x 4
  AlignedVector<double> stretch_limit;    ///< 2; empty: none

  MixedBatch batch(int index) const;
  int node(int element, int k) const {
    return nodes[(static_cast<std::size_t>(element / LANES) * kernel->nodes + k) * LANES + element % LANES];
  }
};

/// The vertices of each element of a body, kernel->nodes each: corners, then midpoints in the kernel's order of edges.
std::vector<std::int32_t> element_vertices(const FemBody& body);

/// Packs the elements of a body. `elements` as element_vertices(), `vertices` their rest positions; nodes are numbered
/// vertex + node_offset. Rotations start at identity: a curved plate is at rest in its rest shape.
/// Errors: bad_input naming the element without area or volume; unavailable when the material has no mixed kernel.
Result<MixedGroup> build_mixed_group(const FemBody& body, const std::vector<std::int32_t>& elements,
                                     const Points& vertices, int node_offset, Isa isa);

/// Weight of a corner at a quadrature point of an element.
double point_weight(const MixedKernel& kernel, int point, int corner);
/// Rest positions of the quadrature points, NP rows per element.
Points mixed_points(const MixedKernel& kernel, const std::vector<std::int32_t>& elements, const Points& vertices);

/// The share of an element's mass that a node carries (diagonal scaling of the consistent mass); sums to one.
double mass_share(ElementKind kind, int node);

} // namespace wry::fem
