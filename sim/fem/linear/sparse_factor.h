#pragma once

#include <memory>
#include <vector>

#include "sim/base/result.h"
#include "sim/fem/linear/block_matrix.h"

namespace wry::fem {

/// What a factor costs, known from the pattern alone.
struct FactorCost {
  double flops = 0.0;   ///< of one factorisation
  double entries = 0.0; ///< of the factor
};

/// A supernodal Cholesky factor whose ordering and pattern are computed once, on the graph of nodes.
class SparseFactor {
public:
  /// Errors: unavailable when the build has no CHOLMOD, out_of_memory when the factor is too large.
  static Result<std::unique_ptr<SparseFactor>> create(const BlockMatrix& matrix);
  virtual ~SparseFactor() = default;

  /// False if the matrix is not positive definite.
  virtual bool factor(const BlockMatrix& matrix) = 0;
  /// Packed vectors.
  virtual void solve(const std::vector<double>& right_side, std::vector<double>& solution) = 0;
  virtual FactorCost cost() const = 0;
};

} // namespace wry::fem
