#pragma once

#include "sim/mpm/matter/elasticity_tensor.h"

/// How grains turn in a flow: frames, the second moment of their directions, and single grains (spec S7, S8).
namespace wry::mpm {

/// Jeffery's (r^2 - 1) / (r^2 + 1) of a grain's length over width; discs (r < 1) are negative, their direction is the
/// normal.
double jeffery_shape(double length_over_width);

/// The turn that shape matching finds on a full stencil of quadratic B-splines: polar(I + dt C), C the affine velocity
/// of APIC. (S7: the stencil's second moment is h^2/4 I.)
Mat3 frame_turn(const Mat3& affine_velocity, double time_step);

/// One direction in a flow for a time step: p <- (exp(dt W) exp(dt l D) p) made unit, by the midpoint rule in its own
/// frame; second order in dt and exact in length.
Vec3 turn_direction(const Vec3& direction, const Mat3& velocity_gradient, double shape, double time_step);

/// Second moment of the directions after a step in a frozen deformation rate D, both in the frame: B Pi B^T / tr with
/// B = exp(dt l D). Symmetric, positive and of trace one for any step.
Mat3 evolve_second_moment(const Mat3& second_moment, const Mat3& deformation_rate, double shape, double time_step);

/// The right-hand side of the paper's eq 9 with its closure.
Mat3 second_moment_rate(const Mat3& second_moment, const Mat3& deformation_rate, double shape);

/// A turn of the frame that makes its second moment diagonal.
struct DiagonalFrame {
  Mat3 turn;          ///< Delta R; the frame becomes Q Delta R
  Mat3 second_moment; ///< Delta R^T Pi Delta R
};

/// Cyclic Jacobi with rotations of at most 45 degrees: continuous in Pi, never swaps labels, and leaves pairs alone
/// whose gap is below 1e-3, where any rotation would do.
DiagonalFrame reorient(const Mat3& second_moment);

/// Parameters of grains whose directions are spread by any amount, between three limits.
struct OrientedParameters {
  Vec3 youngs_modulus; ///< along x, y, z [Pa]
  Vec3 poisson_ratio;  ///< of the plane whose normal is the axis: sqrt(nu_ij nu_ji)
  Vec3 plastic_scale;

  OrthotropicElasticity elasticity() const;
};

/// Values of one axis: E [Pa], nu of the plane normal to it, plastic scale.
struct AxisParameters {
  double youngs_modulus, poisson_ratio, plastic_scale;
};

/// What an axis has when grains point anywhere, all along it, or all across it.
struct OrientationLimits {
  AxisParameters isotropic, parallel, perpendicular;
};

/// Linear in the eigenvalue of each axis: perpendicular at 0, isotropic at 1/3, parallel at 1.
OrientedParameters interpolate_parameters(const OrientationLimits& limits, const Vec3& second_moment_eigenvalues);

/// The violations of the limits at (1/3, 1/3, 1/3), (0, 0, 1) and (0, 1/3, 2/3); none there is none anywhere, since the
/// admissible set is convex in the ratios.
StiffnessCheck check_limits(const OrientationLimits& limits);

} // namespace wry::mpm
