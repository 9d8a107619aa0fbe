#include "sim/geometry/primitives.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

namespace wry::geometry {

namespace {

constexpr double PI = std::numbers::pi;
constexpr double MAX_TRIANGLES = 2e7;

using Lattice = std::array<int, 3>;

Status check_count(double triangles, double target_edge, const char* what) {
  if (triangles <= MAX_TRIANGLES)
    return {};
  return make_error(ErrorCode::bad_input,
                    "{} with edges of {} m has {:.3g} triangles; the limit is {:.0e}: use a longer edge", what,
                    target_edge, triangles, MAX_TRIANGLES);
}

Status check_positive(double value, const char* what) {
  if (value > 0 && std::isfinite(value))
    return {};
  return make_error(ErrorCode::bad_input, "{} must be positive and finite; it is {} m", what, value);
}

// A square of the block's surface, counter-clockwise from outside, cut along corners 0-2 or 1-3.
struct Square {
  std::array<std::int64_t, 4> corners;
  bool cut_from_first;
};

std::int64_t lattice_key(const Lattice& at, const Lattice& cells) {
  return at[0] + (cells[0] + 1LL) * (at[1] + (cells[1] + 1LL) * at[2]);
}

// Diagonals of round ends run outwards, so that no corner of the square becomes a flat triangle on the circle; all
// others alternate, so that none of the two directions is favoured.
bool cuts_from_first(const Block& block, int normal, const Lattice& cell, const Lattice& cells) {
  if (block.section == Section::round && normal == axis_index(block.axis)) {
    const int first = (normal + 1) % 3;
    const int second = (normal + 2) % 3;
    return (2 * cell[first] + 1 < cells[first]) == (2 * cell[second] + 1 < cells[second]);
  }
  return (cell[0] + cell[1] + cell[2]) % 2 == 0;
}

std::vector<Square> block_squares(const Block& block, const Lattice& cells) {
  std::vector<Square> squares;
  for (int normal = 0; normal < 3; ++normal) {
    const int first = (normal + 1) % 3;
    const int second = (normal + 2) % 3;
    for (int side = 0; side < 2; ++side) {
      Lattice at{};
      at[normal] = side * cells[normal];
      for (int j = 0; j < cells[second]; ++j) {
        for (int i = 0; i < cells[first]; ++i) {
          Square square{};
          constexpr int OFFSETS[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
          for (int corner = 0; corner < 4; ++corner) {
            at[first] = i + OFFSETS[corner][0];
            at[second] = j + OFFSETS[corner][1];
            square.corners[corner] = lattice_key(at, cells);
          }
          at[first] = i;
          at[second] = j;
          square.cut_from_first = cuts_from_first(block, normal, at, cells);
          if (side == 0)
            std::swap(square.corners[1], square.corners[3]);
          squares.push_back(square);
        }
      }
    }
  }
  return squares;
}

Vec3 lattice_point(const Block& block, std::int64_t key, const Lattice& cells) {
  const std::int64_t row = cells[0] + 1LL;
  const std::int64_t layer = row * (cells[1] + 1LL);
  const Vec3 s(static_cast<double>(key % row) / cells[0], static_cast<double>(key % layer / row) / cells[1],
               static_cast<double>(key / layer) / cells[2]);
  return block_point(block, s);
}

// Twelve corners of the icosahedron with unit circumradius.
std::array<Vec3, 12> icosahedron_corners() {
  std::array<Vec3, 12> corners;
  int count = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (int signs = 0; signs < 4; ++signs) {
      Vec3 corner = Vec3::Zero();
      corner[axis] = signs & 1 ? 1 : -1;
      corner[(axis + 1) % 3] = (signs & 2 ? 1 : -1) * std::numbers::phi;
      corners[count++] = corner.normalized();
    }
  }
  return corners;
}

std::vector<std::array<int, 3>> icosahedron_faces(const std::array<Vec3, 12>& corners) {
  const auto neighbours = [&](int a, int b) { return corners[a].dot(corners[b]) > 0.4 && a != b; };
  std::vector<std::array<int, 3>> faces;
  for (int a = 0; a < 12; ++a) {
    for (int b = a + 1; b < 12; ++b) {
      for (int c = b + 1; c < 12; ++c) {
        if (!neighbours(a, b) || !neighbours(b, c) || !neighbours(a, c))
          continue;
        const bool outward = corners[a].cross(corners[b]).dot(corners[c]) > 0;
        faces.push_back(outward ? std::array<int, 3>{a, b, c} : std::array<int, 3>{a, c, b});
      }
    }
  }
  return faces;
}

// Vertices of a geodesic sphere, shared between neighbouring faces by their integer weights on the icosahedron's
// corners.
class GeodesicVertices {
public:
  GeodesicVertices(const std::array<Vec3, 12>& corners, int divisions)
      : m_corners(corners)
      , m_divisions(divisions) {}

  std::int32_t index(const std::array<int, 3>& face, int second, int third) {
    std::array<std::pair<int, int>, 3> weights = {std::pair{face[0], m_divisions - second - third},
                                                  std::pair{face[1], second}, std::pair{face[2], third}};
    for (auto& [corner, weight] : weights)
      corner = weight == 0 ? -1 : corner;
    std::sort(weights.begin(), weights.end());
    const auto [entry, is_new] = m_indices.try_emplace(weights, static_cast<std::int32_t>(m_points.size()));
    if (is_new) {
      Vec3 sum = Vec3::Zero();
      for (const auto& [corner, weight] : weights)
        sum += corner < 0 ? Vec3(Vec3::Zero()) : Vec3(weight * m_corners[corner]);
      m_points.push_back(sum.normalized());
    }
    return entry->second;
  }

  const std::vector<Vec3>& points() const { return m_points; }

private:
  const std::array<Vec3, 12>& m_corners;
  int m_divisions;
  std::map<std::array<std::pair<int, int>, 3>, std::int32_t> m_indices;
  std::vector<Vec3> m_points;
};

} // namespace

Result<SurfaceMesh> make_block_surface(const Block& block, double target_edge) {
  Result<Lattice> cells_or_error = cells_for_edge(block, target_edge);
  if (!cells_or_error)
    return std::move(cells_or_error).error();
  const Lattice& cells = *cells_or_error;
  const double count = 4.0 * (1.0 * cells[0] * cells[1] + 1.0 * cells[1] * cells[2] + 1.0 * cells[2] * cells[0]);
  if (Status status = check_count(count, target_edge, "a block"); !status)
    return status.error();

  const std::vector<Square> squares = block_squares(block, cells);
  std::vector<std::int64_t> keys;
  for (const Square& square : squares)
    keys.insert(keys.end(), square.corners.begin(), square.corners.end());
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());

  SurfaceMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(keys.size()), 3);
  for (std::size_t i = 0; i < keys.size(); ++i)
    mesh.vertices.row(static_cast<Eigen::Index>(i)) = lattice_point(block, keys[i], cells).transpose();
  mesh.triangles.resize(static_cast<Eigen::Index>(squares.size()) * 2, 3);
  Eigen::Index row = 0;
  for (const Square& square : squares) {
    std::array<std::int32_t, 4> v{};
    for (int i = 0; i < 4; ++i)
      v[i] = static_cast<std::int32_t>(std::lower_bound(keys.begin(), keys.end(), square.corners[i]) - keys.begin());
    const int shift = square.cut_from_first ? 0 : 1;
    mesh.triangles.row(row++) << v[shift], v[shift + 1], v[shift + 2];
    mesh.triangles.row(row++) << v[shift], v[shift + 2], v[(shift + 3) % 4];
  }
  return mesh;
}

Result<SurfaceMesh> make_sphere(double radius, double target_edge) {
  for (const Status& status :
       {check_positive(radius, "a sphere's radius"), check_positive(target_edge, "a sphere's target edge")})
    if (!status)
      return status.error();
  constexpr double ICOSAHEDRON_EDGE = 1.0514622242382672;
  // Edges near the middle of a face are longest: 1.258 times the icosahedron's edge over the number of divisions, in
  // the limit.
  const double exact = std::max(3.0, std::ceil(1.2584 * ICOSAHEDRON_EDGE * radius / target_edge));
  if (Status status = check_count(20 * exact * exact, target_edge, "a sphere"); !status)
    return status.error();
  const int divisions = static_cast<int>(exact);
  const std::array<Vec3, 12> corners = icosahedron_corners();
  GeodesicVertices vertices(corners, divisions);
  SurfaceMesh mesh;
  mesh.triangles.resize(20LL * divisions * divisions, 3);
  Eigen::Index row = 0;
  for (const std::array<int, 3>& face : icosahedron_faces(corners)) {
    for (int third = 0; third < divisions; ++third) {
      for (int second = 0; second + third < divisions; ++second) {
        const std::int32_t a = vertices.index(face, second, third);
        const std::int32_t b = vertices.index(face, second + 1, third);
        const std::int32_t c = vertices.index(face, second, third + 1);
        mesh.triangles.row(row++) << a, b, c;
        if (second + third + 1 < divisions)
          mesh.triangles.row(row++) << b, vertices.index(face, second + 1, third + 1), c;
      }
    }
  }
  mesh.vertices.resize(static_cast<Eigen::Index>(vertices.points().size()), 3);
  for (std::size_t i = 0; i < vertices.points().size(); ++i)
    mesh.vertices.row(static_cast<Eigen::Index>(i)) = radius * vertices.points()[i].transpose();
  return mesh;
}

Result<SurfaceMesh> make_torus(double major_radius, double minor_radius, Axis axis, double target_edge) {
  for (const Status& status :
       {check_positive(major_radius, "a torus's major radius"), check_positive(minor_radius, "a torus's minor radius"),
        check_positive(target_edge, "a torus's target edge")})
    if (!status)
      return status.error();
  if (minor_radius >= major_radius)
    return make_error(ErrorCode::bad_input, "a torus's minor radius ({} m) must be less than its major radius ({} m)",
                      minor_radius, major_radius);
  const auto even = [](double n) { return 2 * std::max(4.0, std::ceil(n / 2)); };
  const double exact_around = even(2 * PI * (major_radius + minor_radius) / target_edge);
  const double exact_across = even(2 * PI * minor_radius / target_edge);
  if (Status status = check_count(2 * exact_around * exact_across, target_edge, "a torus"); !status)
    return status.error();
  const int around = static_cast<int>(exact_around);
  const int across = static_cast<int>(exact_across);
  const int up = axis_index(axis);
  SurfaceMesh mesh;
  mesh.vertices.resize(1LL * around * across, 3);
  mesh.triangles.resize(2LL * around * across, 3);
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double distance = major_radius + minor_radius * std::cos(2 * PI * j / across);
      Vec3 point;
      point[(up + 1) % 3] = distance * std::cos(2 * PI * i / around);
      point[(up + 2) % 3] = distance * std::sin(2 * PI * i / around);
      point[up] = minor_radius * std::sin(2 * PI * j / across);
      const Eigen::Index cell = 1LL * i * across + j;
      mesh.vertices.row(cell) = point.transpose();
      const auto index = [&](int p, int q) { return (i + p) % around * across + (j + q) % across; };
      const std::array<int, 4> v = {index(0, 0), index(1, 0), index(1, 1), index(0, 1)};
      const int shift = (i + j) % 2;
      mesh.triangles.row(2 * cell) << v[shift], v[shift + 1], v[shift + 2];
      mesh.triangles.row(2 * cell + 1) << v[shift], v[shift + 2], v[(shift + 3) % 4];
    }
  }
  return mesh;
}

} // namespace wry::geometry
