#include "sim/contact/distance.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace wry::contact {

namespace {

/// Edges whose angle is below this (as sin^2) are taken for parallel: their crossing point is round-off.
constexpr double PARALLEL = 1e-14;

PairDistance with_weights(const PairPoints& points, const Vec4& weights) {
  PairDistance pair;
  pair.weights = weights;
  const Vec3 way = points.transpose() * weights;
  pair.distance = way.norm();
  if (pair.distance > 0.0)
    pair.normal = way / pair.distance;
  return pair;
}

void add_parameter(const PairPoints& points, const Vec4& slope, PairDistance& pair) {
  const std::size_t i = static_cast<std::size_t>(pair.parameters++);
  pair.slopes[i] = slope;
  pair.directions[i] = points.transpose() * slope;
}

PairDistance point_point(const PairPoints& points, int a, int b) {
  return with_weights(points, Vec4::Unit(a) - Vec4::Unit(b));
}

/// Point a, in `sign`, and the inside of the edge b c at the parameter s.
PairDistance point_edge(const PairPoints& points, int a, int b, int c, double s, double sign) {
  const Vec4 slope = sign * (Vec4::Unit(b) - Vec4::Unit(c));
  PairDistance pair = with_weights(points, sign * (Vec4::Unit(a) - Vec4::Unit(b)) + s * slope);
  add_parameter(points, slope, pair);
  pair.inverse_metric(0, 0) = 1.0 / pair.directions[0].squaredNorm();
  return pair;
}

/// Two parameters: the normal comes from the directions, which keeps its digits when the distance is tiny.
PairDistance crossing(const PairPoints& points, const Vec4& weights, const Vec4& slope, const Vec4& other) {
  PairDistance pair = with_weights(points, weights);
  add_parameter(points, slope, pair);
  add_parameter(points, other, pair);
  const Vec3& e = pair.directions[0];
  const Vec3& f = pair.directions[1];
  const Vec3 across = e.cross(f);
  const double area = across.squaredNorm();
  pair.inverse_metric << f.squaredNorm(), -e.dot(f), -e.dot(f), e.squaredNorm();
  pair.inverse_metric /= area;
  const Vec3 way = points.transpose() * weights;
  const double height = across.dot(way) / std::sqrt(area);
  pair.distance = std::abs(height);
  pair.normal = across * ((height < 0.0 ? -1.0 : 1.0) / std::sqrt(area));
  return pair;
}

/// Nearest of the edge b c to the point a: at an end or inside.
PairDistance point_segment(const PairPoints& points, int a, int b, int c, double sign) {
  const Vec3 edge = points.row(c) - points.row(b);
  const Vec3 way = points.row(a) - points.row(b);
  const double along = way.dot(edge);
  const double length = edge.squaredNorm();
  if (along <= 0.0)
    return sign > 0.0 ? point_point(points, a, b) : point_point(points, b, a);
  if (along >= length)
    return sign > 0.0 ? point_point(points, a, c) : point_point(points, c, a);
  return point_edge(points, a, b, c, along / length, sign);
}

} // namespace

PairDistance point_triangle_distance(const PairPoints& points) {
  const Vec3 ab = points.row(2) - points.row(1);
  const Vec3 ac = points.row(3) - points.row(1);
  const Vec3 way = points.row(0) - points.row(1);
  const Vec3 normal = ab.cross(ac);
  const double area = normal.squaredNorm();
  const double v = way.cross(ac).dot(normal);
  const double w = ab.cross(way).dot(normal);
  if (area > PARALLEL * ab.squaredNorm() * ac.squaredNorm() && v > 0.0 && w > 0.0 && v + w < area) {
    const double s = v / area;
    const double t = w / area;
    return crossing(points, Vec4(1.0, s + t - 1.0, -s, -t), Vec4(0.0, 1.0, -1.0, 0.0), Vec4(0.0, 1.0, 0.0, -1.0));
  }
  PairDistance best = point_segment(points, 0, 1, 2, 1.0);
  for (const auto& [b, c] : {std::pair{2, 3}, std::pair{3, 1}}) {
    const PairDistance other = point_segment(points, 0, b, c, 1.0);
    if (other.distance < best.distance)
      best = other;
  }
  return best;
}

PairDistance edge_edge_distance(const PairPoints& points) {
  const Vec3 a = points.row(1) - points.row(0);
  const Vec3 b = points.row(3) - points.row(2);
  const Vec3 way = points.row(0) - points.row(2);
  const double aa = a.squaredNorm();
  const double bb = b.squaredNorm();
  const double ab = a.dot(b);
  const double area = a.cross(b).squaredNorm();
  if (area > PARALLEL * aa * bb) {
    const double s = (ab * b.dot(way) - bb * a.dot(way)) / area;
    const double t = (aa * b.dot(way) - ab * a.dot(way)) / area;
    if (s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0)
      return crossing(points, Vec4(1.0 - s, s, t - 1.0, -t), Vec4(-1.0, 1.0, 0.0, 0.0), Vec4(0.0, 0.0, 1.0, -1.0));
  }
  PairDistance best = point_segment(points, 0, 2, 3, 1.0);
  const PairDistance others[3] = {point_segment(points, 1, 2, 3, 1.0), point_segment(points, 2, 0, 1, -1.0),
                                  point_segment(points, 3, 0, 1, -1.0)};
  for (const PairDistance& other : others) {
    if (other.distance < best.distance)
      best = other;
  }
  return best;
}

PairDistance pair_distance(PairKind kind, const PairPoints& points) {
  return kind == PairKind::edge_edge ? edge_edge_distance(points) : point_triangle_distance(points);
}

namespace {

double segment_squared(const Vec3& way, const Vec3& edge) {
  const double share = std::clamp(way.dot(edge) / std::max(edge.squaredNorm(), 1e-300), 0.0, 1.0);
  return (way - share * edge).squaredNorm();
}

} // namespace

double squared_distance(PairKind kind, const PairPoints& points) {
  const Vec3 p = points.row(0);
  const Vec3 q = points.row(1);
  const Vec3 r = points.row(2);
  const Vec3 s = points.row(3);
  const bool edges = kind == PairKind::edge_edge;
  const Vec3 e = edges ? Vec3(q - p) : Vec3(r - q);
  const Vec3 f = edges ? Vec3(s - r) : Vec3(s - q);
  const Vec3 way = edges ? Vec3(p - r) : Vec3(p - q);
  const Vec3 normal = e.cross(f);
  const double area = normal.squaredNorm();
  if (area > PARALLEL * e.squaredNorm() * f.squaredNorm()) {
    const double u = edges ? -way.cross(f).dot(normal) : way.cross(f).dot(normal);
    const double v = edges ? -way.cross(e).dot(normal) : e.cross(way).dot(normal);
    const bool inside = edges ? (u > 0.0 && u < area && v > 0.0 && v < area) : (u > 0.0 && v > 0.0 && u + v < area);
    if (inside) {
      const double height = way.dot(normal);
      return height * height / area;
    }
  }
  if (edges)
    return std::min(
        {segment_squared(p - r, f), segment_squared(q - r, f), segment_squared(r - p, e), segment_squared(s - p, e)});
  return std::min({segment_squared(p - q, e), segment_squared(p - r, s - r), segment_squared(p - q, f)});
}

Gradient distance_gradient(const PairDistance& pair) {
  Gradient gradient;
  for (int k = 0; k < 4; ++k)
    gradient.segment<3>(3 * k) = pair.weights[k] * pair.normal;
  return gradient;
}

Hessian distance_hessian(const PairDistance& pair) {
  // With phi = min_s |r|^2 / 2: phi'' = r_x^T r_x - (r_x^T r_s + r_xs^T r) G^-1 (...)^T, and d'' = (phi'' - d'd'^T) /
  // d.
  Hessian hessian;
  const Mat3 across = Mat3::Identity() - pair.normal * pair.normal.transpose();
  for (int k = 0; k < 4; ++k) {
    for (int l = 0; l < 4; ++l)
      hessian.block<3, 3>(3 * k, 3 * l) = (pair.weights[k] * pair.weights[l]) * across;
  }
  std::array<Gradient, 2> mixed;
  for (int i = 0; i < pair.parameters; ++i) {
    for (int k = 0; k < 4; ++k)
      mixed[i].segment<3>(3 * k) =
          pair.weights[k] * pair.directions[i] + pair.slopes[i][k] * (pair.distance * pair.normal);
  }
  for (int i = 0; i < pair.parameters; ++i) {
    for (int j = 0; j < pair.parameters; ++j)
      hessian.noalias() -= pair.inverse_metric(i, j) * mixed[i] * mixed[j].transpose();
  }
  return hessian / pair.distance;
}

Mollifier evaluate_mollifier(double c, double threshold) {
  if (c >= threshold)
    return {};
  const double share = c / threshold;
  return {share * (2.0 - share), 2.0 * (1.0 - share) / threshold, -2.0 / (threshold * threshold)};
}

double mollifier_threshold(double squared_length_a, double squared_length_b) {
  return 1e-3 * squared_length_a * squared_length_b;
}

double cross_squared(const PairPoints& points) {
  const Vec3 a = points.row(1) - points.row(0);
  const Vec3 b = points.row(3) - points.row(2);
  return a.cross(b).squaredNorm();
}

Gradient cross_squared_gradient(const PairPoints& points) {
  const Vec3 a = points.row(1) - points.row(0);
  const Vec3 b = points.row(3) - points.row(2);
  const Vec3 by_a = 2.0 * (b.squaredNorm() * a - a.dot(b) * b);
  const Vec3 by_b = 2.0 * (a.squaredNorm() * b - a.dot(b) * a);
  Gradient gradient;
  gradient << -by_a, by_a, -by_b, by_b;
  return gradient;
}

Hessian cross_squared_hessian(const PairPoints& points) {
  const Vec3 a = points.row(1) - points.row(0);
  const Vec3 b = points.row(3) - points.row(2);
  const Mat3 aa = 2.0 * (b.squaredNorm() * Mat3::Identity() - b * b.transpose());
  const Mat3 bb = 2.0 * (a.squaredNorm() * Mat3::Identity() - a * a.transpose());
  const Mat3 ab = 4.0 * a * b.transpose() - 2.0 * b * a.transpose() - 2.0 * a.dot(b) * Mat3::Identity();
  Hessian hessian;
  for (int k = 0; k < 2; ++k) {
    for (int l = 0; l < 2; ++l) {
      const double sign = k == l ? 1.0 : -1.0;
      hessian.block<3, 3>(3 * k, 3 * l) = sign * aa;
      hessian.block<3, 3>(6 + 3 * k, 6 + 3 * l) = sign * bb;
      hessian.block<3, 3>(3 * k, 6 + 3 * l) = sign * ab;
      hessian.block<3, 3>(6 + 3 * l, 3 * k) = sign * ab.transpose();
    }
  }
  return hessian;
}

} // namespace wry::contact
