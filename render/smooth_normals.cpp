#include "render/smooth_normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include <Eigen/Geometry>

namespace wry::render {
namespace {

struct EdgeUse {
  std::int32_t low;
  std::int32_t high;
  std::int32_t triangle;
  std::int32_t corner; ///< the edge runs from this corner to the next
};

std::vector<EdgeUse> sorted_edges(const Triangles& triangles) {
  std::vector<EdgeUse> edges;
  edges.reserve(static_cast<std::size_t>(triangles.rows()) * 3);
  for (std::int32_t t = 0; t < triangles.rows(); ++t) {
    for (std::int32_t c = 0; c < 3; ++c) {
      const std::int32_t a = triangles(t, c);
      const std::int32_t b = triangles(t, (c + 1) % 3);
      edges.push_back({std::min(a, b), std::max(a, b), t, c});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const EdgeUse& l, const EdgeUse& r) {
    return std::tie(l.low, l.high, l.triangle) < std::tie(r.low, r.high, r.triangle);
  });
  return edges;
}

/// Corners (3 * triangle + corner) that share a normal, as a union-find forest.
class CornerGroups {
public:
  explicit CornerGroups(std::size_t count)
      : m_parent(count) {
    std::iota(m_parent.begin(), m_parent.end(), 0);
  }
  std::int32_t root(std::int32_t corner) {
    while (m_parent[static_cast<std::size_t>(corner)] != corner) {
      std::int32_t& parent = m_parent[static_cast<std::size_t>(corner)];
      parent = m_parent[static_cast<std::size_t>(parent)];
      corner = parent;
    }
    return corner;
  }
  void join(std::int32_t a, std::int32_t b) {
    a = root(a);
    b = root(b);
    m_parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }

private:
  std::vector<std::int32_t> m_parent;
};

Vec3 scaled_normal(const Eigen::Ref<const Points>& x, const Eigen::Ref<const Triangles>& triangles, Eigen::Index t) {
  const Vec3 a = x.row(triangles(t, 0)).transpose();
  const Vec3 b = x.row(triangles(t, 1)).transpose();
  const Vec3 c = x.row(triangles(t, 2)).transpose();
  return (b - a).cross(c - a);
}

Triangles without_repeats(const Eigen::Ref<const Triangles>& triangles, std::vector<std::int32_t>& which) {
  Triangles kept(triangles.rows(), 3);
  Eigen::Index count = 0;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const auto [a, b, c] = std::array{triangles(t, 0), triangles(t, 1), triangles(t, 2)};
    if (a == b || b == c || c == a)
      continue;
    kept.row(count++) = triangles.row(t);
    which.push_back(static_cast<std::int32_t>(t));
  }
  kept.conservativeResize(count, 3);
  return kept;
}

void join_over_smooth_edges(CornerGroups& groups, const Eigen::Ref<const Points>& positions, const Triangles& triangles,
                            double crease_degrees) {
  const double least_cosine = std::cos(crease_degrees * std::numbers::pi / 180.0);
  const std::vector<EdgeUse> edges = sorted_edges(triangles);
  for (std::size_t first = 0; first < edges.size();) {
    std::size_t last = first + 1;
    while (last < edges.size() && edges[last].low == edges[first].low && edges[last].high == edges[first].high)
      ++last;
    const EdgeUse& l = edges[first];
    const EdgeUse& r = edges[last - 1];
    const bool two = last - first == 2;
    // Neighbours that are wound alike run along their edge in opposite directions.
    if (two && triangles(l.triangle, l.corner) == triangles(r.triangle, (r.corner + 1) % 3)) {
      const Vec3 nl = scaled_normal(positions, triangles, l.triangle);
      const Vec3 nr = scaled_normal(positions, triangles, r.triangle);
      if (nl.dot(nr) >= least_cosine * nl.norm() * nr.norm()) {
        groups.join(3 * l.triangle + l.corner, 3 * r.triangle + (r.corner + 1) % 3);
        groups.join(3 * l.triangle + (l.corner + 1) % 3, 3 * r.triangle + r.corner);
      }
    }
    first = last;
  }
}

double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

} // namespace

SplitSurface split_at_creases(const Eigen::Ref<const Points>& positions, const Eigen::Ref<const Triangles>& triangles,
                              double crease_degrees) {
  SplitSurface surface;
  const Triangles kept = without_repeats(triangles, surface.kept);
  CornerGroups groups(static_cast<std::size_t>(kept.rows()) * 3);
  join_over_smooth_edges(groups, positions, kept, crease_degrees);
  surface.triangles.resize(kept.rows(), 3);
  std::vector<std::int32_t> split_of_root(static_cast<std::size_t>(kept.rows()) * 3, -1);
  for (std::int32_t t = 0; t < kept.rows(); ++t) {
    for (std::int32_t c = 0; c < 3; ++c) {
      std::int32_t& split = split_of_root[static_cast<std::size_t>(groups.root(3 * t + c))];
      if (split < 0) {
        split = static_cast<std::int32_t>(surface.original.size());
        surface.original.push_back(kept(t, c));
      }
      surface.triangles(t, c) = split;
    }
  }
  return surface;
}

Points smooth_normals(const SplitSurface& surface, const Eigen::Ref<const Points>& positions) {
  Points normals = Points::Zero(static_cast<Eigen::Index>(surface.original.size()), 3);
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    std::array<Vec3, 3> x;
    for (int c = 0; c < 3; ++c)
      x[static_cast<std::size_t>(c)] =
          positions.row(surface.original[static_cast<std::size_t>(surface.triangles(t, c))]).transpose();
    const Vec3 scaled = (x[1] - x[0]).cross(x[2] - x[0]);
    const double twice_area = scaled.norm();
    if (!(twice_area > 0.0))
      continue;
    const Vec3 normal = scaled / twice_area;
    for (std::size_t c = 0; c < 3; ++c) {
      const double angle = angle_between(x[(c + 1) % 3] - x[c], x[(c + 2) % 3] - x[c]);
      normals.row(surface.triangles(t, static_cast<Eigen::Index>(c))) += angle * normal.transpose();
    }
  }
  for (Eigen::Index i = 0; i < normals.rows(); ++i) {
    const double length = normals.row(i).norm();
    if (length > 0.0)
      normals.row(i) /= length;
  }
  return normals;
}

} // namespace wry::render
