#include "tests/render/shapes_support.h"

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>

namespace wry::render::testing {
namespace {

constexpr double PI = std::numbers::pi;

/// rings + 1 rows of `segments` points; the first and last row are poles.
template <class Radius> geometry::SurfaceMesh globe(const Vec3& centre, int rings, int segments, const Radius& radius) {
  geometry::SurfaceMesh mesh;
  mesh.vertices.resize((rings - 1) * segments + 2, 3);
  const auto point = [&](double polar, double azimuth) {
    const Vec3 d(std::sin(polar) * std::sin(azimuth), std::cos(polar), std::sin(polar) * std::cos(azimuth));
    return Vec3(centre + radius(d) * d);
  };
  mesh.vertices.row(0) = point(0, 0).transpose();
  mesh.vertices.row(1) = point(PI, 0).transpose();
  const auto index = [&](int ring, int segment) {
    if (ring == 0)
      return 0;
    return ring == rings ? 1 : 2 + (ring - 1) * segments + segment % segments;
  };
  for (int ring = 1; ring < rings; ++ring) {
    for (int segment = 0; segment < segments; ++segment)
      mesh.vertices.row(index(ring, segment)) = point(PI * ring / rings, 2 * PI * segment / segments).transpose();
  }
  mesh.triangles.resize(2 * segments * (rings - 1), 3);
  Eigen::Index next = 0;
  for (int ring = 0; ring < rings; ++ring) {
    for (int segment = 0; segment < segments; ++segment) {
      if (ring > 0)
        mesh.triangles.row(next++) << index(ring, segment), index(ring + 1, segment), index(ring, segment + 1);
      if (ring + 1 < rings)
        mesh.triangles.row(next++) << index(ring, segment + 1), index(ring + 1, segment), index(ring + 1, segment + 1);
    }
  }
  return mesh;
}

} // namespace

geometry::SurfaceMesh sphere(const Vec3& centre, double radius, int rings, int segments) {
  return globe(centre, rings, segments, [radius](const Vec3&) { return radius; });
}

geometry::SurfaceMesh pebble(int rings, int segments) {
  return globe(Vec3(0, 0.45, 0), rings, segments, [](const Vec3& d) {
    const double ears = std::exp(-8.0 * (d - Vec3(0.35, 0.9, 0.1).normalized()).squaredNorm()) +
                        std::exp(-8.0 * (d - Vec3(-0.35, 0.9, 0.1).normalized()).squaredNorm());
    return 0.38 + 0.05 * std::sin(5 * d.x()) * std::cos(4 * d.z()) + 0.3 * ears + 0.05 * std::abs(d.y()) +
           0.006 * std::sin(40 * d.x()) * std::sin(40 * d.y()) * std::sin(40 * d.z());
  });
}

geometry::SurfaceMesh torus(const Vec3& centre, double radius, double tube, int rings, int segments) {
  geometry::SurfaceMesh mesh;
  mesh.vertices.resize(rings * segments, 3);
  mesh.triangles.resize(2 * rings * segments, 3);
  const auto index = [&](int ring, int segment) { return (ring % rings) * segments + segment % segments; };
  Eigen::Index next = 0;
  for (int ring = 0; ring < rings; ++ring) {
    for (int segment = 0; segment < segments; ++segment) {
      const double a = 2 * PI * ring / rings;
      const double b = 2 * PI * segment / segments;
      const double reach = radius + tube * std::cos(b);
      mesh.vertices.row(index(ring, segment)) =
          (centre + Vec3(reach * std::sin(a), tube * std::sin(b), reach * std::cos(a))).transpose();
      mesh.triangles.row(next++) << index(ring, segment), index(ring + 1, segment), index(ring + 1, segment + 1);
      mesh.triangles.row(next++) << index(ring, segment), index(ring + 1, segment + 1), index(ring, segment + 1);
    }
  }
  return mesh;
}

geometry::SurfaceMesh box(const Vec3& low, const Vec3& high) {
  geometry::SurfaceMesh mesh;
  mesh.vertices.resize(8, 3);
  for (int i = 0; i < 8; ++i)
    mesh.vertices.row(i) << (i & 1 ? high : low).x(), (i & 2 ? high : low).y(), (i & 4 ? high : low).z();
  mesh.triangles.resize(12, 3);
  mesh.triangles << 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5,
      3, 7, 5;
  return mesh;
}

MeshScene heap(int count, const Grain& grain, const std::string& look) {
  MeshScene made;
  SceneBody body;
  body.name = "heap";
  body.kind = BodyKind::particles;
  body.look = look;
  body.grain = grain;
  constexpr double HEIGHT = 0.45;
  const double volume = PI * 0.25 * HEIGHT / 3.0;
  body.grain.size *= std::cbrt(0.5 * volume / count / grain.size.prod());
  Channel position{"position", ChannelOn::particle, 3, ChannelStorage::float32, {}};
  Channel orientation{"orientation", ChannelOn::particle, 4, ChannelStorage::float32, {}};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::normal_distribution<double> normal;
  while (position.values.size() < 3 * static_cast<std::size_t>(count)) {
    const Vec3 p(0.5 * unit(random), 0.5 * HEIGHT * (1.0 + unit(random)), 0.5 * unit(random));
    if (std::hypot(p.x(), p.z()) > 0.5 * (1.0 - p.y() / HEIGHT))
      continue;
    position.values.insert(position.values.end(), {p.x(), p.y(), p.z()});
    const Vec4 q = Vec4(normal(random), normal(random), normal(random), normal(random)).normalized();
    orientation.values.insert(orientation.values.end(), {q[0], q[1], q[2], q[3]});
  }
  made.scene.bodies.push_back(std::move(body));
  FrameBody on_frame;
  on_frame.name = "heap";
  on_frame.channels = {std::move(position), std::move(orientation)};
  made.frame.number = 1;
  made.frame.bodies.push_back(std::move(on_frame));
  if (!made.bounds.include(made.scene, made.frame).ok())
    std::abort();
  return made;
}

geometry::SurfaceMesh joined(const geometry::SurfaceMesh& a, const geometry::SurfaceMesh& b) {
  geometry::SurfaceMesh mesh;
  mesh.vertices.resize(a.vertices.rows() + b.vertices.rows(), 3);
  mesh.vertices << a.vertices, b.vertices;
  mesh.triangles.resize(a.triangles.rows() + b.triangles.rows(), 3);
  mesh.triangles << a.triangles, b.triangles.array() + static_cast<std::int32_t>(a.vertices.rows());
  return mesh;
}

} // namespace wry::render::testing
