#pragma once

#include "sim/fem/kernels/batch.h"

namespace wry::fem {

/// Clamps the eigenvalues of one lane's element Hessian to be not negative; D unknowns per node. Returns whether it had
/// to: matrices that are positive semidefinite already are left alone.
template <int D> bool project_element(double* hessian, int lane);

} // namespace wry::fem
