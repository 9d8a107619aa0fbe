#pragma once

#include <array>

#include "sim/fem/kernels/batch.h"

namespace wry::fem {

/// Clamps the eigenvalues of one lane's element Hessian to be not negative; D unknowns per node. `inertia` is added to
/// the diagonal of the positions of each of the four nodes before, and taken away after: what is projected is the sum.
/// Returns whether it had to: matrices that are positive semidefinite already are left alone.
template <int D> bool project_element(double* hessian, int lane, const std::array<double, 4>& inertia);

} // namespace wry::fem
