#pragma once

#include "sim/base/isa.h"
#include "sim/fem/kernels/batch.h"

namespace wry::fem {

/// Clamps the eigenvalues of a batch's linear tets (three unknowns per node, hessian as in BatchDerivatives) to be not
/// negative. `inertia` [N/m], a row per node, is added to the diagonal before and taken away after: what is projected
/// is the sum, or a little more of it where the nodes' differ. The energy must be blind to translations: clamped are
/// the nine directions that are left. Elements that are positive semidefinite already are left alone, to the bit, and
/// so are lanes from `count` on. Returns how many were clamped.
using ProjectElements = int (*)(double* hessian, int count, const double (*inertia)[LANES]);

ProjectElements find_projection(Isa isa);

} // namespace wry::fem
