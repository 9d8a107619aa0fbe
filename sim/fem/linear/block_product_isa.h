#pragma once

#include <cstdint>

namespace wry::fem {

/// The upper half of a symmetric matrix of D x D blocks, a row per node of one section: blocks of row r stand at
/// [row_begin[r], row_begin[r + 1]), columns ascending, the diagonal block first and complete.
template <class Scalar> struct BlockRows {
  const std::int64_t* row_begin;
  const std::int32_t* column;
  const Scalar* values; ///< D x D per block, row-major; readable for 8 entries past the end
};

/// y[begin, end) and spill <- what the rows [begin, end) and their mirror images contribute to A x. Vectors are padded
/// (4 or 8 entries per node) and relative to the section; contributions to nodes at or beyond `end` go to spill, whose
/// first entry belongs to node `end`. y and spill are overwritten; spill_nodes is how many nodes spill covers.
template <class Scalar>
using BlockProductFunction = void (*)(const BlockRows<Scalar>& rows, int begin, int end, const Scalar* x, Scalar* y,
                                      Scalar* spill, int spill_nodes);

/// One pass of conjugate gradients over nodes [begin, end): x += alpha p, r -= alpha q, z = M^-1 r with the inverse
/// diagonal blocks (per node D columns of 4 or 8 entries). dots = {r . r, r . z}.
template <class Scalar>
using BlockUpdateFunction = void (*)(int begin, int end, Scalar alpha, const Scalar* inverses, const Scalar* p,
                                     const Scalar* q, Scalar* x, Scalar* r, Scalar* z, double* dots);

/// Sum of x_i y_i over nodes [begin, end).
template <class Scalar> using BlockDotFunction = double (*)(int begin, int end, const Scalar* x, const Scalar* y);

/// What iterations on padded vectors run, for one scalar and one number of unknowns per node.
template <class Scalar> struct BlockFunctions {
  BlockProductFunction<Scalar> product;
  BlockUpdateFunction<Scalar> update;
  BlockDotFunction<Scalar> dot;
};

/// For 3 and 6 unknowns per node.
struct BlockProductTable {
  BlockFunctions<float> float3, float6;
  BlockFunctions<double> double3, double6;
};

namespace sse4 {
BlockProductTable block_products();
}
namespace avx2 {
BlockProductTable block_products();
}
namespace avx512 {
BlockProductTable block_products();
}

} // namespace wry::fem
