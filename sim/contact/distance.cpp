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

/// From the nearest point of an edge to a point that is `way` from its beginning.
Vec3 way_from_segment(const Vec3& way, const Vec3& edge) {
  const double share = std::clamp(way.dot(edge) / std::max(edge.squaredNorm(), 1e-300), 0.0, 1.0);
  return way - share * edge;
}

/// Two edges, or two sides of a triangle from the same corner, and the way to the first primitive.
struct Directions {
  Vec3 e, f, way, normal;
  double area = 0.0; ///< |normal|^2

  Directions(PairKind kind, const PairPoints& points) {
    const bool edges = kind == PairKind::edge_edge;
    e = points.row(edges ? 1 : 2) - points.row(edges ? 0 : 1);
    f = points.row(3) - points.row(edges ? 2 : 1);
    way = points.row(0) - points.row(edges ? 2 : 1);
    normal = e.cross(f);
    area = normal.squaredNorm();
  }
  /// Whether the nearest points are inside both primitives.
  bool are_inside(PairKind kind) const {
    const bool edges = kind == PairKind::edge_edge;
    if (!(area > PARALLEL * e.squaredNorm() * f.squaredNorm()))
      return false;
    const double u = edges ? -way.cross(f).dot(normal) : way.cross(f).dot(normal);
    const double v = edges ? -way.cross(e).dot(normal) : e.cross(way).dot(normal);
    return edges ? (u > 0.0 && u < area && v > 0.0 && v < area) : (u > 0.0 && v > 0.0 && u + v < area);
  }
};

/// The shortest way to the first primitive where an end or a side is nearest.
Vec3 way_from_sides(PairKind kind, const PairPoints& points, const Directions& directions) {
  const auto between = [&](int a, int b) { return Vec3(points.row(a) - points.row(b)); };
  Vec3 best;
  if (kind == PairKind::edge_edge) {
    best = way_from_segment(directions.way, directions.f);
    for (const Vec3& other :
         {way_from_segment(between(1, 2), directions.f), Vec3(-way_from_segment(-directions.way, directions.e)),
          Vec3(-way_from_segment(between(3, 0), directions.e))}) {
      if (other.squaredNorm() < best.squaredNorm())
        best = other;
    }
    return best;
  }
  best = way_from_segment(directions.way, directions.e);
  for (const Vec3& other :
       {way_from_segment(between(0, 2), between(3, 2)), way_from_segment(directions.way, directions.f)}) {
    if (other.squaredNorm() < best.squaredNorm())
      best = other;
  }
  return best;
}

} // namespace

double squared_distance(PairKind kind, const PairPoints& points) {
  const Directions directions(kind, points);
  if (!directions.are_inside(kind))
    return way_from_sides(kind, points, directions).squaredNorm();
  const double height = directions.way.dot(directions.normal);
  return height * height / directions.area;
}

Vec3 separating_direction(PairKind kind, const PairPoints& points) {
  const Directions directions(kind, points);
  if (!directions.are_inside(kind))
    return way_from_sides(kind, points, directions).normalized();
  const double sign = directions.way.dot(directions.normal) < 0.0 ? -1.0 : 1.0;
  return sign / std::sqrt(directions.area) * directions.normal;
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
