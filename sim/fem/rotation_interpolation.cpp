#include "sim/fem/rotation_interpolation.h"

#include <array>
#include <cmath>

#include <Eigen/LU>

#include "sim/base/rotation.h"

namespace wry::fem {

namespace {

/// 2 atan2(|u|, w) u / |u|: of length [0, 2 pi), continuous where rotation_vector() jumps from pi to -pi.
Vec3 long_rotation_vector(const Vec4& q) {
  const double sine = q.tail<3>().norm();
  return sine == 0.0 ? Vec3(Vec3::Zero()) : Vec3(2.0 * std::atan2(sine, q[0]) / sine * q.tail<3>());
}

Vec4 blend_vectors(std::span<const Vec4> rotations, std::span<const double> weights) {
  const double sign = rotations[0][0] < 0.0 ? -1.0 : 1.0;
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < rotations.size(); ++k)
    sum += weights[k] * long_rotation_vector(sign * rotations[k]);
  return quaternion_exponential(sum);
}

Vec4 blend_quaternions(std::span<const Vec4> rotations, std::span<const double> weights) {
  Vec4 sum = Vec4::Zero();
  for (std::size_t k = 0; k < rotations.size(); ++k)
    sum += weights[k] * rotations[k];
  return sum.normalized();
}

} // namespace

Vec4 interpolate_rotation(PointRotations rule, std::span<const Vec4> rotations, std::span<const double> weights) {
  Vec4 q = Vec4::Zero();
  switch (rule) {
  case PointRotations::rotation_vectors:
    q = blend_vectors(rotations, weights);
    break;
  case PointRotations::quaternion_blend:
    q = blend_quaternions(rotations, weights);
    break;
  case PointRotations::interpolated_velocity:
  case PointRotations::spherical_average:
    q = spherical_average(rotations, weights);
    break;
  }
  return q.dot(rotations[0]) < 0.0 ? Vec4(-q) : q;
}

Eigen::Matrix4d quadrature_weights() {
  constexpr double NEAR = 0.5854101966249685;
  constexpr double FAR = 0.1381966011250105;
  Eigen::Matrix4d weights = Eigen::Matrix4d::Constant(FAR);
  weights.diagonal().setConstant(NEAR);
  return weights;
}

Mat3 wryness(const Vec4& at, std::span<const Vec4> rotations, const Eigen::Matrix<double, 4, 3>& gradients) {
  Mat3 gamma;
  for (int j = 0; j < 3; ++j) {
    Vec4 slope = Vec4::Zero();
    for (int k = 0; k < 4; ++k)
      slope += gradients(k, j) * rotations[static_cast<std::size_t>(k)];
    gamma.col(j) = 2.0 * quaternion_product(quaternion_conjugate(at), slope).tail<3>();
  }
  return gamma;
}

Mat3 spherical_wryness(std::span<const Vec4> rotations, std::span<const double> weights,
                       const Eigen::Matrix<double, 4, 3>& gradients) {
  // The average has sum w_k u_k = 0 with u_k the rotation vectors from it to the corners. Turning it by epsilon in its
  // own frame changes u_k by -J^-1(u_k) epsilon, J the left Jacobian: sum w_k J^-1(u_k) epsilon = sum dw_k u_k.
  const Vec4 back = quaternion_conjugate(spherical_average(rotations, weights));
  Eigen::Matrix<double, 3, 4> vectors;
  Mat3 sum = Mat3::Zero();
  for (int k = 0; k < 4; ++k) {
    const Vec3 u = rotation_vector(quaternion_product(back, rotations[static_cast<std::size_t>(k)]));
    vectors.col(k) = u;
    const double angle = u.norm();
    const double square = angle * angle;
    // 1/t^2 - (1 + cos t)/(2 t sin t)
    const double bend = angle < 1e-2 ? 1.0 / 12.0 + square / 720.0 + square * square / 30240.0
                                     : 1.0 / square - 0.5 / (angle * std::tan(0.5 * angle));
    const Mat3 hat = cross_matrix(u);
    sum += weights[static_cast<std::size_t>(k)] * (Mat3::Identity() - 0.5 * hat + bend * hat * hat);
  }
  return sum.inverse() * vectors * gradients;
}

} // namespace wry::fem
