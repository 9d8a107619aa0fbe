#pragma once

#include "sim/fem/kernels/points.h"

namespace wry::fem::WRY_ISA {

/// Curvature energies. They add to the energy and to torque and K of the points, and up to ORDER write the derivatives
/// by the increments of the nodes, from which the gradient of the quaternion field is made, where those of the points
/// are added afterwards.
template <Order ORDER>
void add_isotropic_curvature(const Batch& batch, const NodeFields& fields, int lane, const Element& element,
                             Points& points, Real& energy, double* gradient, double* hessian);
template <Order ORDER>
void add_orthotropic_curvature(const Batch& batch, const NodeFields& fields, int lane, const Element& element,
                               Points& points, Real& energy, double* gradient, double* hessian);

} // namespace wry::fem::WRY_ISA
