#pragma once

#include <cmath>

#include <Eigen/Core>

#include "sim/base/types.h"

/// Symmetric tensors as 6-vectors in Mandel's order (xx, yy, zz, yz, zx, xy) with shears times sqrt 2, for stress and
/// strain alike: then a 4-tensor with minor symmetries is a 6 x 6, `A : S` a product, its inverse the inverse, and a
/// rotation is orthogonal.
namespace wry::mpm {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

inline constexpr double ROOT_2 = 1.4142135623730950488;

/// The symmetric part of `s` as a 6-vector.
inline Vec6 to_mandel(const Mat3& s) {
  constexpr double HALF_ROOT_2 = 0.5 * ROOT_2;
  Vec6 v;
  v << s(0, 0), s(1, 1), s(2, 2), HALF_ROOT_2 * (s(1, 2) + s(2, 1)), HALF_ROOT_2 * (s(2, 0) + s(0, 2)),
      HALF_ROOT_2 * (s(0, 1) + s(1, 0));
  return v;
}

inline Mat3 from_mandel(const Vec6& v) {
  constexpr double HALF_ROOT_2 = 0.5 * ROOT_2;
  const double yz = HALF_ROOT_2 * v[3], zx = HALF_ROOT_2 * v[4], xy = HALF_ROOT_2 * v[5];
  Mat3 s;
  s << v[0], xy, zx, xy, v[1], yz, zx, yz, v[2];
  return s;
}

/// S -> D S D^T as a 6 x 6.
Mat6 congruence_map(const Mat3& D);

} // namespace wry::mpm
