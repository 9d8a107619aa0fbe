#pragma once

#include <vector>

#include "sim/fem/fem_model.h"
#include "sim/fem/linear/block_matrix.h"

/// The exponential update of rotations (eq 25 of the micropolar paper). Elements know increments as Cayley's only
/// (eq 26); a turn by the rotation vector r is Cayley's increment a(r) = 2 tan(|r|/2) r/|r|. Quadrature points
/// interpolate these. Derivatives by a become derivatives by r through T = da/dr.
namespace wry::fem {

Vec3 cayley_of_rotation_vector(const Vec3& r);
Vec3 rotation_vector_of_cayley(const Vec3& a);

/// T = da/dr, symmetric.
Mat3 cayley_slope(const Vec3& r);
/// The second derivative of g . a(r).
Mat3 cayley_curvature(const Vec3& r, const Vec3& g);

/// Turns a gradient by velocities and Cayley increments, packed and scaled by beta, into one by velocities and omega.
void chain_gradient(const DofLayout& layout, const Stage& stage, const Trial& trial, std::vector<double>& gradient);
/// The same of a Hessian; `gradient` is that by Cayley increments, before its chain.
void chain_hessian(const Stage& stage, const Trial& trial, const std::vector<double>& gradient, BlockMatrix& matrix);

} // namespace wry::fem
