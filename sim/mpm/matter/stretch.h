#pragma once

#include "sim/base/types.h"

/// Decompositions of 3 x 3 matrices that keep their digits at extreme stretches, in double, one at a time: the
/// reference of the batched kernels.
namespace wry::mpm {

/// F = V R with V = axes diag(stretches) axes^T.
struct LeftPolar {
  Vec3 stretches;
  Mat3 axes; ///< columns, of V in the world
  Mat3 rotation;
};

/// Of F with det F > 0. Eigenvectors of F F^T, stretches as the lengths of the rows of axes^T F after one-sided Jacobi
/// sweeps on them: eigenvalues of F F^T alone lose all digits at a ratio of 1e6 (spec S4).
LeftPolar left_polar(const Mat3& F);

struct SymmetricEigen {
  Vec3 values;
  Mat3 vectors; ///< columns
};

/// By cyclic Jacobi; eigenvalues in no particular order.
SymmetricEigen symmetric_eigen(const Mat3& S);

} // namespace wry::mpm
