#include "render/grain_shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace wry::render {
namespace {

using Vector = Eigen::Vector3f;

Vector vector_of(const std::array<float, 3>& v) {
  return {v[0], v[1], v[2]};
}

std::array<float, 3> array_of(const Vector& v) {
  return {v.x(), v.y(), v.z()};
}

/// A grain at its place within the exposure, its half axes turned towards the viewer.
struct Facing {
  Vector centre;
  Vector x, y, z;

  Facing(const DrawGrain& grain, const ViewPoint& from, float seconds)
      : centre(vector_of(grain.centre) + seconds * vector_of(grain.velocity)) {
    const Vector towards = from.towards(centre);
    const auto turned = [&](const std::array<float, 3>& axis) {
      const Vector a = vector_of(axis);
      return Vector(a.dot(towards) >= 0.f ? a : -a);
    };
    x = turned(grain.axes[0]);
    y = turned(grain.axes[1]);
    z = turned(grain.axes[2]);
  }
};

/// The six corners about the nearest one (x + y + z): each second one belongs to one face only.
std::array<Vector, 6> ring_of(const Facing& f) {
  return {f.centre + f.x + f.y - f.z, f.centre + f.x - f.y - f.z, f.centre + f.x - f.y + f.z,
          f.centre - f.x - f.y + f.z, f.centre - f.x + f.y + f.z, f.centre - f.x + f.y - f.z};
}

Vector unit_or_up(const Vector& v) {
  const float length = v.norm();
  return length > 0.f ? Vector(v / length) : Vector(Vector::UnitY());
}

std::uint32_t darker(std::uint32_t word, std::uint32_t divisor) {
  const std::uint32_t r = ((word >> 16) & 255u) / divisor;
  const std::uint32_t g = ((word >> 8) & 255u) / divisor;
  const std::uint32_t b = (word & 255u) / divisor;
  return (word & 0xff000000u) | (r << 16) | (g << 8) | b;
}

/// A polygon about the end of a cylinder, flat.
void append_end(const Facing& f, const Vector& a, const Vector& b, const Vector& normal, float inner, float outer,
                int points, std::uint32_t word, GrainTriangles& out) {
  const auto base = static_cast<std::uint32_t>(out.vertices.size());
  const std::uint32_t code = octahedral_word(normal);
  const int rings = inner > 0.f ? 2 : 1;
  // A polygon inside the circle covers less than it: a little wider covers as much.
  const float corner = 2.f * std::numbers::pi_v<float> / static_cast<float>(points);
  const float wider = points < 6 ? std::sqrt(corner / std::sin(corner)) : 1.f;
  for (int p = 0; p < points; ++p) {
    const float angle = 2.f * std::numbers::pi_v<float> * static_cast<float>(p) / static_cast<float>(points);
    const Vector around = wider * (std::cos(angle) * a + std::sin(angle) * b);
    for (int ring = 0; ring < rings; ++ring)
      out.vertices.push_back({array_of(f.centre + f.z + (ring == 0 ? outer : inner) * around), code, word});
  }
  for (int p = 0; p < points; ++p) {
    const auto at = [&](int point, int ring) {
      return base + static_cast<std::uint32_t>((point % points) * rings + ring);
    };
    if (rings == 2)
      out.indices.insert(out.indices.end(), {at(p, 0), at(p + 1, 0), at(p, 1), at(p, 1), at(p + 1, 0), at(p + 1, 1)});
    else if (p >= 2)
      out.indices.insert(out.indices.end(), {base, at(p - 1, 0), at(p, 0)});
  }
}

} // namespace

std::uint32_t octahedral_word(const Eigen::Vector3f& normal) {
  const Vector n = normal / std::max(normal.cwiseAbs().sum(), 1e-20f);
  Eigen::Vector2f e = n.head<2>();
  if (n.z() < 0.f)
    e = Eigen::Vector2f((1.f - std::abs(n.y())) * (n.x() >= 0.f ? 1.f : -1.f),
                        (1.f - std::abs(n.x())) * (n.y() >= 0.f ? 1.f : -1.f));
  const auto snorm = [](float v) {
    return static_cast<std::uint32_t>(
        static_cast<std::uint16_t>(static_cast<std::int16_t>(std::lround(std::clamp(v, -1.f, 1.f) * 32767.f))));
  };
  return snorm(e.x()) | (snorm(e.y()) << 16);
}

void append_boxes(std::span<const DrawGrain> grains, const ViewPoint& from, float seconds,
                  std::vector<GrainVertex>& out) {
  out.reserve(out.size() + grains.size() * BOX_VERTICES);
  for (const DrawGrain& grain : grains) {
    const Facing f(grain, from, seconds);
    const std::array<Vector, 6> ring = ring_of(f);
    // Faces in the ring's order: x, z, y.
    const std::array<std::uint32_t, 3> normals = {octahedral_word(f.x), octahedral_word(f.z), octahedral_word(f.y)};
    out.push_back({array_of(f.centre + f.x + f.y + f.z), 0, grain.word});
    for (std::size_t i = 0; i < 6; ++i)
      out.push_back({array_of(ring[i]), normals[i / 2], grain.word});
  }
}

std::array<std::uint32_t, BOX_INDICES> box_indices() {
  return {0, 1, 2, 3, 0, 2, 0, 3, 4, 5, 0, 4, 0, 5, 6, 1, 0, 6};
}

void append_outlines(std::span<const DrawGrain> grains, const ViewPoint& from, float seconds,
                     std::vector<std::array<float, 3>>& out) {
  out.reserve(out.size() + grains.size() * OUTLINE_VERTICES);
  for (const DrawGrain& grain : grains) {
    const Vector centre = vector_of(grain.centre) + seconds * vector_of(grain.velocity);
    const Vector towards = from.towards(centre).normalized();
    std::array<Vector, 3> sides;
    for (std::size_t a = 0; a < 3; ++a) {
      const Vector axis = vector_of(grain.axes[a]);
      sides[a] = axis - axis.dot(towards) * towards;
    }
    const std::array<float, 3> areas = {sides[1].cross(sides[2]).norm(), sides[2].cross(sides[0]).norm(),
                                        sides[0].cross(sides[1]).norm()};
    const auto least = static_cast<std::size_t>(std::max_element(areas.begin(), areas.end()) - areas.begin());
    const float scale = std::sqrt((areas[0] + areas[1] + areas[2]) / std::max(areas[least], 1e-30f));
    const Vector u = std::min(scale, 4.f) * sides[(least + 1) % 3];
    const Vector v = std::min(scale, 4.f) * sides[(least + 2) % 3];
    for (const Vector& corner : {Vector(-u - v), Vector(u - v), Vector(u + v), Vector(v - u)})
      out.push_back(array_of(centre + corner));
  }
}

std::array<std::uint32_t, OUTLINE_INDICES> outline_indices() {
  return {0, 1, 2, 0, 2, 3};
}

void append_cylinders(std::span<const DrawGrain> grains, GrainShape shape, int segments, const ViewPoint& from,
                      float seconds, GrainTriangles& out) {
  for (const DrawGrain& grain : grains) {
    const Facing f(grain, from, seconds);
    const Vector a = vector_of(grain.axes[0]);
    const Vector b = vector_of(grain.axes[1]);
    const float square_a = std::max(a.squaredNorm(), 1e-20f);
    const float square_b = std::max(b.squaredNorm(), 1e-20f);
    const Vector towards = from.towards(f.centre);
    // A point a cos + b sin has the normal a cos / |a|^2 + b sin / |b|^2; the middle strip's faces the viewer most.
    const float middle = std::atan2(b.dot(towards) / square_b, a.dot(towards) / square_a);
    const auto base = static_cast<std::uint32_t>(out.vertices.size());
    for (int s = 0; s <= segments; ++s) {
      const float angle =
          middle + std::numbers::pi_v<float> * (static_cast<float>(s) / static_cast<float>(segments) - 0.5f);
      const Vector around = std::cos(angle) * a + std::sin(angle) * b;
      const std::uint32_t code =
          octahedral_word(unit_or_up(std::cos(angle) / square_a * a + std::sin(angle) / square_b * b));
      out.vertices.push_back({array_of(f.centre + around + f.z), code, grain.word});
      out.vertices.push_back({array_of(f.centre + around - f.z), code, grain.word});
    }
    for (int s = 0; s < segments; ++s) {
      const std::uint32_t i = base + 2 * static_cast<std::uint32_t>(s);
      out.indices.insert(out.indices.end(), {i, i + 1, i + 2, i + 2, i + 1, i + 3});
    }
    const Vector normal = unit_or_up(f.z);
    if (shape == GrainShape::straw) {
      constexpr float WALL = 0.72f;
      append_end(f, a, b, normal, WALL, 1.f, 2 * segments, grain.word, out);
      append_end(f, a, b, normal, 0.f, WALL, 2 * segments, darker(grain.word, 4), out);
    } else {
      append_end(f, a, b, normal, 0.f, 1.f, 2 * segments, grain.word, out);
    }
  }
}

void append_spheres(std::span<const DrawGrain> grains, int segments, const ViewPoint& from, float seconds,
                    GrainTriangles& out) {
  const int around = std::max(6, 2 * segments);
  const int rings = std::max(1, segments / 2);
  // A ring inside the circle covers less than it: a little wider covers as much.
  const float wider = std::sqrt(2.f * std::numbers::pi_v<float> / static_cast<float>(around) /
                                std::sin(2.f * std::numbers::pi_v<float> / static_cast<float>(around)));
  for (const DrawGrain& grain : grains) {
    const Facing f(grain, from, seconds);
    Mat3 shape;
    for (int a = 0; a < 3; ++a)
      shape.col(a) = vector_of(grain.axes[static_cast<std::size_t>(a)]).cast<double>();
    const Eigen::Matrix3f to_ball = shape.inverse().cast<float>();
    const Eigen::Matrix3f from_ball = shape.cast<float>();
    // Within the ball's own space the viewer sees the half about this pole.
    const Vector pole = unit_or_up(to_ball * from.towards(f.centre));
    const Vector side = pole.unitOrthogonal();
    const Vector other = pole.cross(side);
    const auto base = static_cast<std::uint32_t>(out.vertices.size());
    const auto vertex = [&](const Vector& on_ball, float scale) {
      const Vector normal = unit_or_up(to_ball.transpose() * on_ball);
      out.vertices.push_back({array_of(f.centre + from_ball * (scale * on_ball)), octahedral_word(normal), grain.word});
    };
    vertex(pole, 1.f);
    for (int ring = 1; ring <= rings; ++ring) {
      const float polar = 0.5f * std::numbers::pi_v<float> * static_cast<float>(ring) / static_cast<float>(rings);
      for (int p = 0; p < around; ++p) {
        const float angle = 2.f * std::numbers::pi_v<float> * static_cast<float>(p) / static_cast<float>(around);
        vertex(std::cos(polar) * pole + std::sin(polar) * (std::cos(angle) * side + std::sin(angle) * other), wider);
      }
    }
    for (int p = 0; p < around; ++p) {
      const auto at = [&](int ring, int point) {
        return base + 1 + static_cast<std::uint32_t>((ring - 1) * around + point % around);
      };
      out.indices.insert(out.indices.end(), {base, at(1, p), at(1, p + 1)});
      for (int ring = 1; ring < rings; ++ring)
        out.indices.insert(out.indices.end(), {at(ring, p), at(ring + 1, p), at(ring, p + 1), at(ring, p + 1),
                                               at(ring + 1, p), at(ring + 1, p + 1)});
    }
  }
}

std::size_t round_vertices(GrainShape shape, int segments) {
  const auto n = static_cast<std::size_t>(segments);
  if (shape == GrainShape::sphere)
    return 1 + std::max<std::size_t>(6, 2 * n) * std::max<std::size_t>(1, n / 2);
  return 2 * (n + 1) + (shape == GrainShape::straw ? 6 * n : 2 * n);
}

int round_segments(float pixels) {
  if (pixels < 3.f)
    return 0;
  if (pixels < 6.f)
    return 2;
  if (pixels < 9.f)
    return 3;
  if (pixels < 30.f)
    return 6;
  return pixels < 100.f ? 10 : 20;
}

} // namespace wry::render
