#include "shots/meshes/make/bunny_shape.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace wry::make {

namespace {

/// Smooth minimum: equals min(a, b) where they differ by more than `blend`, rounder below.
double join(double a, double b, double blend) {
  const double h = std::max(blend - std::abs(a - b), 0.0) / blend;
  return std::min(a, b) - h * h * h * blend / 6.0;
}

double intersect(double a, double b, double blend) {
  return -join(-a, -b, blend);
}

/// Distance to an axis-aligned ellipsoid, exact on its surface and of the right size nearby.
double ellipsoid(const Vec3& point, const Vec3& centre, const Vec3& radii) {
  const Vec3 scaled = (point - centre).cwiseQuotient(radii);
  const double k0 = scaled.norm();
  const double k1 = scaled.cwiseQuotient(radii).norm();
  return k1 < 1e-12 ? -radii.minCoeff() : k0 * (k0 - 1.0) / k1;
}

/// The same, tilted by `degrees` about an axis through its centre.
double tilted_ellipsoid(const Vec3& point, const Vec3& centre, const Vec3& radii, const Vec3& axis, double degrees) {
  const Eigen::AngleAxisd turn(-degrees * M_PI / 180.0, axis);
  return ellipsoid(centre + turn * (point - centre), centre, radii);
}

/// Distance to a limb that narrows from `start` to `end`.
double limb(const Vec3& point, const Vec3& start, const Vec3& end, double start_radius, double end_radius) {
  const Vec3 along = end - start;
  const double s = std::clamp((point - start).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (point - start - s * along).norm() - (start_radius + s * (end_radius - start_radius));
}

double torso(const Vec3& p) {
  double d = tilted_ellipsoid(p, {0, 0.278, -0.15}, {0.235, 0.285, 0.30}, Vec3::UnitX(), 12);
  d = join(d, tilted_ellipsoid(p, {0, 0.36, 0.10}, {0.175, 0.26, 0.19}, Vec3::UnitX(), 14), 0.16);
  d = join(d, ellipsoid(p, {0, 0.40, 0.235}, {0.115, 0.12, 0.085}), 0.10); // bib
  d = join(d, ellipsoid(p, {0, 0.195, -0.462}, {0.085, 0.088, 0.085}), 0.035);
  return d;
}

/// The legs of the side x > 0: a haunch with its long foot, a foreleg with its paw. Feet reach below the ground, where
/// they are cut flat.
double legs(const Vec3& p) {
  double d = tilted_ellipsoid(p, {0.205, 0.215, -0.13}, {0.105, 0.20, 0.215}, Vec3::UnitX(), -18);
  d = join(d, limb(p, {0.200, 0.030, -0.06}, {0.226, 0.034, 0.185}, 0.080, 0.068), 0.045);
  const double fore = join(limb(p, {0.095, 0.30, 0.21}, {0.085, 0.05, 0.275}, 0.084, 0.062),
                           limb(p, {0.086, 0.026, 0.265}, {0.084, 0.030, 0.36}, 0.064, 0.060), 0.05);
  return join(d, fore, 0.04);
}

double head(const Vec3& p) {
  double d = tilted_ellipsoid(p, {0, 0.665, 0.205}, {0.152, 0.155, 0.185}, Vec3::UnitX(), 12);
  const Vec3 m(std::abs(p.x()), p.y(), p.z());
  d = join(d, ellipsoid(m, {0.082, 0.615, 0.265}, {0.082, 0.08, 0.095}), 0.07); // cheeks
  d = join(d, ellipsoid(m, {0, 0.625, 0.36}, {0.072, 0.062, 0.075}), 0.07);     // snout
  d = join(d, ellipsoid(m, {0.034, 0.598, 0.385}, {0.045, 0.042, 0.05}), 0.03); // lips
  d = join(d, ellipsoid(m, {0, 0.648, 0.405}, {0.038, 0.032, 0.034}), 0.025);   // nose
  return d;
}

/// Eyes: a shallow socket with a ball in it.
double with_eye(const Vec3& m, double d) {
  const Vec3 centre(0.150, 0.715, 0.300);
  d = intersect(d, -((m - centre).norm() - 0.052), 0.04);
  return join(d, (m - Vec3(0.094, 0.703, 0.275)).norm() - 0.044, 0.012);
}

/// The ear of the side x > 0: a long leaf, hollowed at the front, leaning out and back.
double ear(const Vec3& p) {
  const Vec3 root(0.072, 0.76, 0.125);
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(-0.20, Vec3::UnitZ()) * Eigen::AngleAxisd(-0.30, Vec3::UnitX()) *
                                Eigen::AngleAxisd(0.30, Vec3::UnitY()))
                                   .toRotationMatrix();
  const Vec3 q = turn.transpose() * (p - root);
  double d = ellipsoid(q, {0, 0.17, 0}, {0.086, 0.195, 0.064});
  d = join(d, limb(q, {0, -0.04, 0}, {0, 0.10, 0}, 0.056, 0.062), 0.05);
  return intersect(d, -ellipsoid(q, {0, 0.185, 0.103}, {0.062, 0.17, 0.062}), 0.05);
}

} // namespace

double bunny_distance(const Vec3& point) {
  // Limbs that come close to the middle are joined one after the other, not mirrored: so no crease is left there.
  const Vec3 other(-point.x(), point.y(), point.z());
  const Vec3 m(std::abs(point.x()), point.y(), point.z());
  double d = join(join(torso(point), legs(point), 0.05), legs(other), 0.05);
  d = join(d, with_eye(m, head(point)), 0.12);
  d = join(join(d, ear(point), 0.05), ear(other), 0.05);
  return intersect(d, -point.y(), 0.05);
}

} // namespace wry::make
