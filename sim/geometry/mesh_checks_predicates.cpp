#include "sim/geometry/mesh_checks_predicates.h"

#include <cmath>
#include <vector>

#include <Eigen/Geometry>

namespace wry::geometry {

namespace {

using Vec2 = Eigen::Vector2d;

// A sum of doubles that do not overlap, in order of size: an exact number.
using Expansion = std::vector<double>;

void grow(Expansion& sum, double term) {
  Expansion next;
  next.reserve(sum.size() + 1);
  double carry = term;
  for (const double part : sum) {
    const double total = carry + part;
    const double virtual_part = total - carry;
    const double error = (carry - (total - virtual_part)) + (part - virtual_part);
    if (error != 0)
      next.push_back(error);
    carry = total;
  }
  if (carry != 0 || next.empty())
    next.push_back(carry);
  sum = std::move(next);
}

Expansion plus(Expansion a, const Expansion& b) {
  for (const double term : b)
    grow(a, term);
  return a;
}

Expansion times(const Expansion& a, const Expansion& b) {
  Expansion product = {0.0};
  for (const double x : a) {
    for (const double y : b) {
      const double high = x * y;
      grow(product, std::fma(x, y, -high));
      grow(product, high);
    }
  }
  return product;
}

Expansion minus(Expansion a, const Expansion& b) {
  for (const double term : b)
    grow(a, -term);
  return a;
}

Expansion difference(double a, double b) {
  Expansion result = {a};
  grow(result, -b);
  return result;
}

int sign(double value) {
  return (value > 0) - (value < 0);
}

int exact_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  Expansion m[3][3];
  for (int i = 0; i < 3; ++i) {
    m[0][i] = difference(a[i], d[i]);
    m[1][i] = difference(b[i], d[i]);
    m[2][i] = difference(c[i], d[i]);
  }
  Expansion determinant = {0.0};
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const int k = (i + 2) % 3;
    const Expansion minor = minus(times(m[1][j], m[2][k]), times(m[1][k], m[2][j]));
    determinant = plus(std::move(determinant), times(m[0][i], minor));
  }
  return sign(determinant.back());
}

bool on_segment(const Vec2& p, const Vec2& a, const Vec2& b) {
  return std::min(a[0], b[0]) <= p[0] && p[0] <= std::max(a[0], b[0]) && std::min(a[1], b[1]) <= p[1] &&
         p[1] <= std::max(a[1], b[1]);
}

bool segments_meet(const Vec2& p, const Vec2& q, const Vec2& a, const Vec2& b) {
  const int pa = orientation(a, b, p);
  const int qa = orientation(a, b, q);
  const int ap = orientation(p, q, a);
  const int bp = orientation(p, q, b);
  if (pa * qa < 0 && ap * bp < 0)
    return true;
  return (pa == 0 && on_segment(p, a, b)) || (qa == 0 && on_segment(q, a, b)) || (ap == 0 && on_segment(a, p, q)) ||
         (bp == 0 && on_segment(b, p, q));
}

bool contains(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& p) {
  const int s = orientation(a, b, p);
  const int t = orientation(b, c, p);
  const int u = orientation(c, a, p);
  return (s >= 0 && t >= 0 && u >= 0) || (s <= 0 && t <= 0 && u <= 0);
}

// Leaves out the coordinate along which the triangle is thinnest.
int dropped_axis(const Vec3& a, const Vec3& b, const Vec3& c) {
  int axis = 0;
  (b - a).cross(c - a).cwiseAbs().maxCoeff(&axis);
  return axis;
}

Vec2 drop(const Vec3& point, int axis) {
  return {point[(axis + 1) % 3], point[(axis + 2) % 3]};
}

bool coplanar_segment_meets_triangle(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const int axis = dropped_axis(a, b, c);
  const Vec2 p2 = drop(p, axis);
  const Vec2 q2 = drop(q, axis);
  const Vec2 a2 = drop(a, axis);
  const Vec2 b2 = drop(b, axis);
  const Vec2 c2 = drop(c, axis);
  return contains(a2, b2, c2, p2) || contains(a2, b2, c2, q2) || segments_meet(p2, q2, a2, b2) ||
         segments_meet(p2, q2, b2, c2) || segments_meet(p2, q2, c2, a2);
}

} // namespace

int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 x = a - d;
  const Vec3 y = b - d;
  const Vec3 z = c - d;
  const double determinant = x.dot(y.cross(z));
  const Vec3 ax = x.cwiseAbs();
  const Vec3 ay = y.cwiseAbs();
  const Vec3 az = z.cwiseAbs();
  const double permanent = ax[0] * (ay[1] * az[2] + ay[2] * az[1]) + ax[1] * (ay[2] * az[0] + ay[0] * az[2]) +
                           ax[2] * (ay[0] * az[1] + ay[1] * az[0]);
  // Shewchuk's bound is 7.77e-16; the sum above may be added up in another order.
  if (std::abs(determinant) > 1e-15 * permanent)
    return sign(determinant);
  return permanent == 0 ? 0 : exact_orientation(a, b, c, d);
}

int orientation(const Vec2& a, const Vec2& b, const Vec2& c) {
  const double left = (a[0] - c[0]) * (b[1] - c[1]);
  const double right = (a[1] - c[1]) * (b[0] - c[0]);
  const double determinant = left - right;
  if (std::abs(determinant) > 4e-16 * (std::abs(left) + std::abs(right)))
    return sign(determinant);
  const Expansion exact = minus(times(difference(a[0], c[0]), difference(b[1], c[1])),
                                times(difference(a[1], c[1]), difference(b[0], c[0])));
  return sign(exact.back());
}

bool segment_meets_triangle(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const int side_p = orientation(a, b, c, p);
  const int side_q = orientation(a, b, c, q);
  if (side_p * side_q > 0)
    return false;
  if (side_p == 0 && side_q == 0)
    return coplanar_segment_meets_triangle(p, q, a, b, c);
  const int s = orientation(p, q, a, b);
  const int t = orientation(p, q, b, c);
  const int u = orientation(p, q, c, a);
  return (s >= 0 && t >= 0 && u >= 0) || (s <= 0 && t <= 0 && u <= 0);
}

bool folds_onto(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  if (orientation(a, b, c, d) != 0)
    return false;
  const int axis = dropped_axis(a, b, c);
  return orientation(drop(a, axis), drop(b, axis), drop(c, axis)) *
             orientation(drop(a, axis), drop(b, axis), drop(d, axis)) >
         0;
}

} // namespace wry::geometry
