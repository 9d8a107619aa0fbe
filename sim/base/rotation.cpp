#include "sim/base/rotation.h"

#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Dense>

namespace wry {

namespace {

/// sin(x) / x
double sinc(double x) {
  return std::abs(x) < 1e-4 ? 1.0 - x * x / 6.0 : std::sin(x) / x;
}

} // namespace

Vec4 identity_quaternion() {
  return {1.0, 0.0, 0.0, 0.0};
}

Vec4 quaternion_product(const Vec4& a, const Vec4& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3], a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1]};
}

Vec4 quaternion_conjugate(const Vec4& q) {
  return {q[0], -q[1], -q[2], -q[3]};
}

Mat3 rotation_matrix(const Vec4& q) {
  const Vec3 u = q.tail<3>();
  return (q[0] * q[0] - u.squaredNorm()) * Mat3::Identity() + 2.0 * u * u.transpose() + 2.0 * q[0] * cross_matrix(u);
}

Vec4 quaternion_of(const Mat3& rotation) {
  const Eigen::Quaterniond q(rotation);
  return Vec4(q.w(), q.x(), q.y(), q.z()).normalized();
}

Mat3 cross_matrix(const Vec3& v) {
  Mat3 m;
  m << 0.0, -v[2], v[1], v[2], 0.0, -v[0], -v[1], v[0], 0.0;
  return m;
}

Vec4 cayley_update(const Vec4& q0, const Vec3& a) {
  const Vec4 half(0.0, 0.5 * a[0], 0.5 * a[1], 0.5 * a[2]);
  const Vec4 q = q0 + quaternion_product(half, q0);
  // The norm of q and not sqrt(1 + |a|^2/4): rounding errors of many updates do not add up.
  return q / q.norm();
}

Vec3 cayley_increment(const Vec4& q0, const Vec4& q) {
  const Vec4 turn = quaternion_product(q, quaternion_conjugate(q0));
  return (2.0 / turn[0]) * turn.tail<3>();
}

Vec4 quaternion_exponential(const Vec3& v) {
  const double half = 0.5 * v.norm();
  Vec4 q;
  q << std::cos(half), 0.5 * sinc(half) * v;
  return q;
}

Mat3 rodrigues(const Vec3& v) {
  const double angle = v.norm();
  const double s = sinc(0.5 * angle);
  const Mat3 hat = cross_matrix(v);
  return Mat3::Identity() + sinc(angle) * hat + 0.5 * s * s * hat * hat;
}

Vec3 rotation_vector(const Vec4& q) {
  const double sine = q.tail<3>().norm();
  const double cosine = std::abs(q[0]);
  if (sine == 0.0)
    return Vec3::Zero();
  const double angle = 2.0 * std::atan2(sine, cosine);
  return std::copysign(angle / sine, q[0]) * q.tail<3>();
}

double rotation_distance(const Vec4& a, const Vec4& b) {
  const Vec4 turn = quaternion_product(quaternion_conjugate(a), b);
  return 2.0 * std::atan2(turn.tail<3>().norm(), std::abs(turn[0]));
}

Vec4 spherical_average(std::span<const Vec4> rotations, std::span<const double> weights) {
  std::vector<Vec4> aligned(rotations.begin(), rotations.end());
  Vec4 mean = Vec4::Zero();
  for (std::size_t k = 0; k < aligned.size(); ++k) {
    if (aligned[k].dot(aligned[0]) < 0.0)
      aligned[k] = -aligned[k];
    mean += weights[k] * aligned[k];
  }
  mean.normalize();
  constexpr int MOST_ITERATIONS = 100;
  double last = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < MOST_ITERATIONS; ++iteration) {
    Vec4 step = Vec4::Zero();
    for (std::size_t k = 0; k < aligned.size(); ++k) {
      const double cosine = mean.dot(aligned[k]);
      const Vec4 tangent = aligned[k] - cosine * mean; // of length sin(angle), without the cancellation of acos
      const double sine = tangent.norm();
      const double angle = std::atan2(sine, cosine);
      step += weights[k] * (sine > 0.0 ? angle / sine : 1.0) * tangent;
    }
    const double length = step.norm();
    mean = (std::cos(length) * mean + sinc(length) * step).normalized();
    if (length < 1e-14 || length >= last) // round-off may keep it above the tolerance
      break;
    last = length;
  }
  return mean;
}

Mat3 polar_rotation(const Mat3& F) {
  const Eigen::JacobiSVD<Mat3> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vec3 signs(1.0, 1.0, svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0 ? -1.0 : 1.0);
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

} // namespace wry
