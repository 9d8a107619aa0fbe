#include "pipeline/assets/polygon.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace wry::pipeline {

namespace {

// Cutting ears takes the square of the number of corners; larger polygons are fans.
constexpr std::size_t MAX_EAR_CORNERS = 2000;

// Newell's normal; its length is twice the area.
Vec3 polygon_normal(std::span<const Vec3> points) {
  Vec3 normal = Vec3::Zero();
  for (std::size_t i = 0; i < points.size(); ++i)
    normal += (points[i] - points[0]).cross(points[(i + 1) % points.size()] - points[0]);
  return normal;
}

double doubled_area(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& normal) {
  return (b - a).cross(c - a).dot(normal);
}

// What is left of the polygon, as places in `points`.
using Ring = std::vector<std::size_t>;

// How round the ear at ring[i] is; not positive: no ear.
double ear_quality(const Ring& ring, std::size_t i, std::span<const Vec3> points, const Vec3& normal) {
  const std::size_t n = ring.size();
  const Vec3& a = points[ring[(i + n - 1) % n]];
  const Vec3& b = points[ring[i]];
  const Vec3& c = points[ring[(i + 1) % n]];
  const double area = doubled_area(a, b, c, normal);
  if (!(area > 0))
    return 0;
  for (std::size_t k = 2; k + 1 < n; ++k) {
    const Vec3& p = points[ring[(i + k) % n]];
    if (doubled_area(a, b, p, normal) >= 0 && doubled_area(b, c, p, normal) >= 0 && doubled_area(c, a, p, normal) >= 0)
      return 0;
  }
  return area / ((b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm());
}

} // namespace

std::vector<std::array<std::int32_t, 3>> triangulate_polygon(std::span<const std::int32_t> corners,
                                                             std::span<const Vec3> points) {
  std::vector<std::array<std::int32_t, 3>> triangles;
  Ring ring(corners.size());
  for (std::size_t i = 0; i < ring.size(); ++i)
    ring[i] = i;
  const Vec3 normal = polygon_normal(points).normalized();
  bool has_ears =
      corners.size() > 3 && corners.size() <= MAX_EAR_CORNERS && normal.allFinite() && normal.squaredNorm() > 0;
  while (ring.size() > 3 && has_ears) {
    std::size_t best = 0;
    double best_quality = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const double quality = ear_quality(ring, i, points, normal);
      if (quality > best_quality) {
        best = i;
        best_quality = quality;
      }
    }
    has_ears = best_quality > 0;
    if (!has_ears)
      break;
    const std::size_t n = ring.size();
    triangles.push_back({corners[ring[(best + n - 1) % n]], corners[ring[best]], corners[ring[(best + 1) % n]]});
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(best));
  }
  for (std::size_t i = 1; i + 1 < ring.size(); ++i)
    triangles.push_back({corners[ring[0]], corners[ring[i]], corners[ring[i + 1]]});
  return triangles;
}

} // namespace wry::pipeline
