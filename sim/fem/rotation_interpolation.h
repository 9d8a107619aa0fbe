#pragma once

#include <span>

#include "sim/base/types.h"
#include "sim/fem/fem_plan.h"

namespace wry::fem {

/// The rotation between those of an element's corners, by a rule (spec §10). Signs of `rotations` are aligned, as those
/// of an element are; the result is aligned to them. Weights sum to one. `interpolated_velocity` has no such rule,
/// since it follows history: it is the spherical average here.
Vec4 interpolate_rotation(PointRotations rule, std::span<const Vec4> rotations, std::span<const double> weights);

/// Weights of the corners at the four quadrature points; point p lies near corner p.
Eigen::Matrix4d quadrature_weights();

/// The wryness of a field of rotations inside an element, Gamma in the material frame [1/m]: 2 vec(conj(q) q_,j) for
/// the rotation `at` a point and the quaternions of the corners, whose shape functions have the gradients `gradients`
/// (4 x 3, a row per corner).
Mat3 wryness(const Vec4& at, std::span<const Vec4> rotations, const Eigen::Matrix<double, 4, 3>& gradients);

/// The wryness of the spherical average at the point with these weights, by differentiating the average.
Mat3 spherical_wryness(std::span<const Vec4> rotations, std::span<const double> weights,
                       const Eigen::Matrix<double, 4, 3>& gradients);

} // namespace wry::fem
