#pragma once

#include <array>

#include "sim/fem/kernels/batch.h"

namespace wry::fem {

/// Clamps the eigenvalues of one lane's element Hessian of positions and rotations to be not negative (that of
/// positions alone: kernels/projection.h). `inertia` is added to the diagonal of the positions of each of the four
/// nodes before, and taken away after: what is projected is the sum. Returns whether it had to: matrices that are
/// positive semidefinite already are left alone.
bool project_element(double* hessian, int lane, const std::array<double, 4>& inertia);

} // namespace wry::fem
