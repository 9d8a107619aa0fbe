#pragma once

#include "sim/fem/kernels/batch.h"
#include "sim/fem/kernels/tensors.h"

/// What every tet energy starts from and ends with, on WIDTH elements at a time.
namespace wry::fem::WRY_ISA {

/// Geometry and moduli of WIDTH tets. Index k - 1 stands for node k: node 0 is minus the sum of the others.
struct Element {
  Vec edges[3];     ///< deformed x_k - x_0
  Vec gradients[3]; ///< of the shape functions, in the rest shape
  Real volume, mu, lambda, mu_c;
};

WRY_INLINE Element load_element(const Batch& batch, const NodeFields& fields, int lane) {
  Element element;
  const Vec x0 = gather_vec(fields.positions, batch.nodes + lane);
  for (int k = 0; k < 3; ++k) {
    element.edges[k] = gather_vec(fields.positions, batch.nodes + (k + 1) * LANES + lane) - x0;
    element.gradients[k] = load_vec(batch.shape_gradients + 3 * k * LANES + lane);
  }
  element.volume = load(batch.volume + lane);
  element.mu = load(batch.mu + lane);
  element.lambda = load(batch.lambda + lane);
  element.mu_c = load(batch.mu_c + lane);
  return element;
}

/// F = sum of edges times shape gradients
WRY_INLINE Mat deformation_gradient(const Element& element) {
  return outer(element.edges[0], element.gradients[0]) + outer(element.edges[1], element.gradients[1]) +
         outer(element.edges[2], element.gradients[2]);
}

/// det F without F: the deformed volume over the rest volume.
WRY_INLINE Real volume_ratio(const Element& element) {
  return dot(cross(element.edges[0], element.edges[1]), element.edges[2]) *
         dot(cross(element.gradients[0], element.gradients[1]), element.gradients[2]);
}

/// Energy and its derivatives by the positions of nodes 1..3, times the volume.
struct PositionPart {
  Real energy;
  Vec force[3];  ///< + dE/dx_k
  Mat blocks[6]; ///< 11 12 13 22 23 33
};

WRY_INLINE void store_vec(double* to, const Vec& v) {
  store(to, v.x);
  store(to + LANES, v.y);
  store(to + 2 * LANES, v.z);
}

/// Writes a 3 x 3 matrix into a row-major block with `columns` columns.
WRY_INLINE void store_block(double* to, int columns, const Mat& m) {
  store_vec(to, m.r0);
  store_vec(to + columns * LANES, m.r1);
  store_vec(to + 2 * columns * LANES, m.r2);
}

/// Gradient entries of the positions, node 0 included; `dofs` per node.
WRY_INLINE void store_forces(double* gradient, int dofs, const Vec (&force)[3]) {
  store_vec(gradient, -(force[0] + force[1] + force[2]));
  for (int k = 0; k < 3; ++k)
    store_vec(gradient + (k + 1) * dofs * LANES, force[k]);
}

/// Number of block (k, l), k <= l, in BatchDerivatives::hessian.
WRY_INLINE constexpr int block_number(int k, int l) {
  return k * (7 - k) / 2 + l;
}

/// Position blocks of all nodes from those of nodes 1..3; `dofs` per node.
WRY_INLINE void store_position_blocks(double* hessian, int dofs, const Mat (&blocks)[6]) {
  const int size = dofs * dofs * LANES;
  const Mat column1 = blocks[0] + transposed(blocks[1]) + transposed(blocks[2]);
  const Mat column2 = blocks[1] + blocks[3] + transposed(blocks[4]);
  const Mat column3 = blocks[2] + blocks[4] + blocks[5];
  store_block(hessian + size * block_number(0, 0), dofs, column1 + column2 + column3);
  store_block(hessian + size * block_number(0, 1), dofs, -column1);
  store_block(hessian + size * block_number(0, 2), dofs, -column2);
  store_block(hessian + size * block_number(0, 3), dofs, -column3);
  for (int i = 0; i < 6; ++i)
    store_block(hessian + size * (block_number(1, 1) + i), dofs, blocks[i]);
}

} // namespace wry::fem::WRY_ISA
