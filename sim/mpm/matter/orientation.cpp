#include "sim/mpm/matter/orientation.h"

#include <cmath>

#include "sim/base/rotation.h"
#include "sim/mpm/matter/stretch.h"

namespace wry::mpm {

namespace {

constexpr double GAP = 1e-3;
constexpr int SWEEPS = 8;

Mat3 symmetric_exponential(const Mat3& S) {
  const SymmetricEigen eigen = symmetric_eigen(S);
  const Vec3 values = eigen.values.array().exp();
  return eigen.vectors * values.asDiagonal() * eigen.vectors.transpose();
}

/// exp(S) v. Within a step S is small, and a few terms of the series give all digits at a tenth of the eigenvectors'
/// cost.
Vec3 exponential_times(const Mat3& S, const Vec3& v) {
  constexpr double SMALL = 0.5; // the last term is then below 1e-17 of v
  constexpr int TERMS = 15;
  if (!(S.norm() <= SMALL))
    return symmetric_exponential(S) * v;
  Vec3 sum = v, term = v;
  const double negligible = 1e-34 * v.squaredNorm();
  for (int k = 1; k <= TERMS && term.squaredNorm() > negligible; ++k) {
    term = (S * term) / static_cast<double>(k);
    sum += term;
  }
  return sum;
}

} // namespace

double jeffery_shape(double r) {
  return (r * r - 1.0) / (r * r + 1.0);
}

Mat3 frame_turn(const Mat3& affine_velocity, double time_step) {
  return polar_rotation(Mat3::Identity() + time_step * affine_velocity);
}

Vec3 turn_direction(const Vec3& direction, const Mat3& L, double shape, double dt) {
  const Mat3 D = 0.5 * (L + L.transpose());
  const Mat3 W = 0.5 * (L - L.transpose());
  const Vec3 spin(W(2, 1), W(0, 2), W(1, 0));
  const Mat3 half = rodrigues(0.5 * dt * spin);
  const Vec3 turned = half * exponential_times(dt * shape * D, half * direction);
  return turned.normalized();
}

Mat3 evolve_second_moment(const Mat3& Pi, const Mat3& D, double shape, double dt) {
  const Mat3 B = symmetric_exponential(dt * shape * D);
  const Mat3 next = B * Pi * B.transpose();
  const Mat3 symmetric = 0.5 * (next + next.transpose());
  return symmetric / symmetric.trace();
}

Mat3 second_moment_rate(const Mat3& Pi, const Mat3& D, double shape) {
  return shape * (D * Pi + Pi * D - 2.0 * (D.cwiseProduct(Pi)).sum() * Pi);
}

DiagonalFrame reorient(const Mat3& second_moment) {
  DiagonalFrame result{Mat3::Identity(), second_moment};
  Mat3& Pi = result.second_moment;
  for (int sweep = 0; sweep < SWEEPS; ++sweep) {
    for (const auto& [p, q] : {std::pair{0, 1}, std::pair{0, 2}, std::pair{1, 2}}) {
      double difference = Pi(p, p) - Pi(q, q), twice = 2.0 * Pi(p, q);
      if (std::sqrt(difference * difference + twice * twice) < GAP || twice == 0.0)
        continue;
      if (difference < 0.0) { // atan, not atan2: at most 45 degrees
        difference = -difference;
        twice = -twice;
      }
      const double theta = 0.5 * std::atan2(twice, difference);
      Mat3 G = Mat3::Identity();
      G(p, p) = G(q, q) = std::cos(theta);
      G(p, q) = -std::sin(theta);
      G(q, p) = std::sin(theta);
      const Mat3 turned = G.transpose() * Pi * G;
      Pi = 0.5 * (turned + turned.transpose());
      const Mat3 turn = result.turn * G;
      result.turn = turn;
    }
  }
  return result;
}

OrthotropicElasticity OrientedParameters::elasticity() const {
  const Vec3& E = youngs_modulus;
  OrthotropicElasticity e;
  e.youngs_modulus = E;
  e.nu_yz = poisson_ratio[0] * std::sqrt(E[1] / E[2]);
  e.nu_xz = poisson_ratio[1] * std::sqrt(E[0] / E[2]);
  e.nu_xy = poisson_ratio[2] * std::sqrt(E[0] / E[1]);
  return e;
}

OrientedParameters interpolate_parameters(const OrientationLimits& limits, const Vec3& eigenvalues) {
  const auto blend = [&limits](double lambda, double AxisParameters::*member) {
    const double iso = limits.isotropic.*member;
    return lambda < 1.0 / 3.0 ? iso + (1.0 - 3.0 * lambda) * (limits.perpendicular.*member - iso)
                              : iso + 0.5 * (3.0 * lambda - 1.0) * (limits.parallel.*member - iso);
  };
  OrientedParameters result;
  for (int i = 0; i < 3; ++i) {
    result.youngs_modulus[i] = blend(eigenvalues[i], &AxisParameters::youngs_modulus);
    result.poisson_ratio[i] = blend(eigenvalues[i], &AxisParameters::poisson_ratio);
    result.plastic_scale[i] = blend(eigenvalues[i], &AxisParameters::plastic_scale);
  }
  return result;
}

StiffnessCheck check_limits(const OrientationLimits& limits) {
  StiffnessCheck worst;
  for (const Vec3& eigenvalues :
       {Vec3(1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0), Vec3(0, 0, 1), Vec3(0, 1.0 / 3.0, 2.0 / 3.0)}) {
    StiffnessCheck check = check_orthotropic(interpolate_parameters(limits, eigenvalues).elasticity());
    if (!check.positive_definite())
      return check;
    worst = check;
  }
  return worst;
}

} // namespace wry::mpm
