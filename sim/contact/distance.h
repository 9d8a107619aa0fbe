#pragma once

#include <array>

#include "sim/base/types.h"
#include "sim/contact/ccd.h"

namespace wry::contact {

using PairPoints = Eigen::Matrix<double, 4, 3>; ///< a row per point, as in CcdBatch
using Gradient = Eigen::Matrix<double, 12, 1>;  ///< point by point
using Hessian = Eigen::Matrix<double, 12, 12>;

/// How near two primitives are. The nearest points differ by r = sum of weights[k] x_k = distance * normal; they lie on
/// features of `parameters` dimensions (0: point-point, 1: point-edge, 2: point-triangle inside or edge-edge crossing),
/// along which r changes by the directions, weights by the slopes.
struct PairDistance {
  double distance = 0.0;          ///< [m]
  Vec3 normal = Vec3::Zero();     ///< unit, from the second primitive to the first; zero when they touch
  Vec4 weights = Vec4::Zero();    ///< sum to zero
  int parameters = 0;             ///< that are free at the minimum
  std::array<Vec3, 2> directions; ///< dr / ds_i [m]
  std::array<Vec4, 2> slopes;     ///< dweights / ds_i
  Eigen::Matrix2d inverse_metric; ///< of the directions, parameters x parameters [1/m^2]
};

/// The least distance of a point (row 0) and a triangle.
PairDistance point_triangle_distance(const PairPoints& points);
/// The least distance of two edges (rows 0, 1 and 2, 3).
PairDistance edge_edge_distance(const PairPoints& points);
PairDistance pair_distance(PairKind kind, const PairPoints& points);

/// The squared distance alone, for searches.
double squared_distance(PairKind kind, const PairPoints& points);
/// The unit direction between the nearest points, from the second primitive to the first; zero when they touch.
Vec3 separating_direction(PairKind kind, const PairPoints& points);

/// The distance's derivative: weights x normal.
Gradient distance_gradient(const PairDistance& pair);
/// The distance's second derivative where the nearest features stay the same; needs distance > 0.
Hessian distance_hessian(const PairDistance& pair);

/// Where edges are near parallel their distance has kinks. This factor, smooth and within [0, 1], takes such pairs out
/// (Li et al. 2020, eq 24): -c^2/e^2 + 2 c/e for c = |a x b|^2 < e, else 1. Point-triangle pairs beside them stay.
struct Mollifier {
  double value = 1.0;
  double slope = 0.0;  ///< by c
  double second = 0.0; ///< by c
};
Mollifier evaluate_mollifier(double cross_squared, double threshold);
/// The threshold e from the edges at rest: 1e-3 |a|^2 |b|^2.
double mollifier_threshold(double squared_length_a, double squared_length_b);

/// c = |a x b|^2 of the edges and its derivatives.
double cross_squared(const PairPoints& points);
Gradient cross_squared_gradient(const PairPoints& points);
Hessian cross_squared_hessian(const PairPoints& points);

} // namespace wry::contact
