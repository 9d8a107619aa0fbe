#include "sim/geometry/remesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>

#include "sim/geometry/closest_point_tree.h"
#include "sim/geometry/remesh_half_edges.h"

namespace wry::geometry {

namespace {

constexpr double RADIANS = M_PI / 180.0;
constexpr double TOO_LONG = 4.0 / 3.0;
constexpr double TOO_SHORT = 4.0 / 5.0;
/// A crease vertex whose two sharp edges turn more than this is a corner.
constexpr double CORNER_TURN = 45;
/// Sizes grow by at most this much per length along the surface.
constexpr double GRADING = 0.5;

double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

double dihedral_turn(const HalfEdgeMesh& mesh, int h) {
  return angle_between(mesh.normal(h / 3), mesh.normal(mesh.twin(h) / 3));
}

/// Calls visit(half-edge) for every half-edge that leaves the vertex.
template <class Visit> void for_each_out(const HalfEdgeMesh& mesh, int vertex, const Visit& visit) {
  int h = mesh.out(vertex);
  do {
    visit(h);
    h = mesh.around(h);
  } while (h != mesh.out(vertex));
}

/// Sharp edges of a mesh as a tree of degenerate triangles.
std::optional<ClosestPointTree> feature_tree(const HalfEdgeMesh& mesh) {
  std::vector<int> edges;
  for (int h = 0; h < mesh.half_edges(); ++h)
    if (mesh.is_feature(h) && h < mesh.twin(h))
      edges.push_back(h);
  if (edges.empty())
    return std::nullopt;
  SurfaceMesh lines;
  lines.vertices.resize(static_cast<Eigen::Index>(2 * edges.size()), 3);
  lines.triangles.resize(static_cast<Eigen::Index>(edges.size()), 3);
  for (int i = 0; i < static_cast<int>(edges.size()); ++i) {
    const int h = edges[static_cast<std::size_t>(i)];
    lines.vertices.row(2 * i) = mesh.point(mesh.from(h)).transpose();
    lines.vertices.row(2 * i + 1) = mesh.point(mesh.to(h)).transpose();
    lines.triangles.row(i) << 2 * i, 2 * i + 1, 2 * i + 1;
  }
  return ClosestPointTree(lines);
}

/// Bending per length [1/m] around each vertex, sharp edges left out.
std::vector<double> vertex_curvature(const HalfEdgeMesh& mesh) {
  std::vector<double> bend(static_cast<std::size_t>(mesh.vertices()), 0.0);
  std::vector<double> area = bend;
  for (int h = 0; h < mesh.half_edges(); ++h) {
    const auto v = static_cast<std::size_t>(mesh.from(h));
    area[v] += mesh.normal(h / 3).norm() / 6.0;
    if (!mesh.is_feature(h))
      bend[v] += 0.5 * dihedral_turn(mesh, h) * mesh.length(h);
  }
  // Averages over two rings, so that the facets of a coarse input do not count as bends.
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<double> smooth_bend = bend;
    std::vector<double> smooth_area = area;
    for (int h = 0; h < mesh.half_edges(); ++h) {
      smooth_bend[static_cast<std::size_t>(mesh.from(h))] += bend[static_cast<std::size_t>(mesh.to(h))];
      smooth_area[static_cast<std::size_t>(mesh.from(h))] += area[static_cast<std::size_t>(mesh.to(h))];
    }
    bend = std::move(smooth_bend);
    area = std::move(smooth_area);
  }
  for (std::size_t v = 0; v < bend.size(); ++v)
    bend[v] = area[v] > 0 ? bend[v] / area[v] : 0.0;
  return bend;
}

class Remesher {
public:
  Remesher(const SurfaceMesh& surface, HalfEdgeMesh mesh, const RemeshSettings& settings)
      : m_settings(settings)
      , m_mesh(std::move(mesh))
      , m_tree(surface) {
    mark_features();
    m_lines = feature_tree(m_mesh);
    make_sizes();
  }

  SurfaceMesh run() {
    for (int pass = 0; pass < m_settings.passes; ++pass) {
      split_long_edges();
      collapse_short_edges();
      flip_edges();
      smooth();
    }
    for (int pass = 0; pass < 4; ++pass) {
      flip_to_delaunay();
      smooth();
    }
    flip_to_delaunay();
    flip_folds();
    return m_mesh.to_surface();
  }

private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  void mark_features() {
    for (int h = 0; h < m_mesh.half_edges(); ++h)
      if (dihedral_turn(m_mesh, h) > m_settings.feature_angle * RADIANS)
        m_mesh.mark_feature(h);
    m_is_corner.assign(at(m_mesh.vertices()), 0);
    for (int v = 0; v < m_mesh.vertices(); ++v) {
      if (!m_mesh.is_vertex_alive(v))
        continue;
      const std::vector<int> lines = feature_neighbours(v);
      if (lines.empty())
        continue;
      m_is_corner[at(v)] =
          lines.size() != 2 || angle_between(m_mesh.point(v) - m_mesh.point(lines[0]),
                                             m_mesh.point(lines[1]) - m_mesh.point(v)) > CORNER_TURN * RADIANS;
    }
  }

  std::vector<int> feature_neighbours(int v) const {
    std::vector<int> neighbours;
    for_each_out(m_mesh, v, [&](int h) {
      if (m_mesh.is_feature(h))
        neighbours.push_back(m_mesh.to(h));
    });
    return neighbours;
  }

  void make_sizes() {
    m_sizes = vertex_curvature(m_mesh);
    for (double& size : m_sizes) {
      const double bent = m_settings.turn * RADIANS / std::max(size, 1e-9);
      size = std::clamp(bent, m_settings.finest * m_settings.edge, m_settings.edge);
    }
    bool changed = true;
    for (int sweep = 0; changed && sweep < 100; ++sweep) {
      changed = false;
      for (int h = 0; h < m_mesh.half_edges(); ++h) {
        const double limit = m_sizes[at(m_mesh.from(h))] + GRADING * m_mesh.length(h);
        if (m_sizes[at(m_mesh.to(h))] > limit) {
          m_sizes[at(m_mesh.to(h))] = limit;
          changed = true;
        }
      }
    }
    m_vertex_size = m_sizes;
  }

  double size_at(const ClosestPoint& place) const {
    double size = 0;
    for (int k = 0; k < 3; ++k)
      size += place.barycentric[k] * m_sizes[at(m_tree.mesh().triangles(place.triangle, k))];
    return size;
  }

  /// Wanted length of an edge between two vertices.
  double wanted_length(int a, int b) const { return (m_vertex_size[at(a)] + m_vertex_size[at(b)]) / 2; }

  double relative_length(int h) const { return m_mesh.length(h) / wanted_length(m_mesh.from(h), m_mesh.to(h)); }

  Vec3 vertex_normal(int v) const {
    Vec3 sum = Vec3::Zero();
    for_each_out(m_mesh, v, [&](int h) { sum += m_mesh.normal(h / 3); });
    return sum.normalized();
  }

  /// A place on the original surface and the size wanted there.
  struct Target {
    Vec3 point;
    double size;
  };

  /// The place of the original surface nearest to x, unless it lies on another sheet that faces away from `normal`.
  Target put_back(const Vec3& x, const Vec3& normal, const Target& otherwise) const {
    const ClosestPoint nearest = m_tree.closest(x);
    return m_tree.smooth_normal(nearest).dot(normal) > 0 ? Target{nearest.point, size_at(nearest)} : otherwise;
  }

  Target put_on_line(const Vec3& x, double size) const { return {m_lines->closest(x).point, size}; }
  Target now(int v) const { return {m_mesh.point(v), m_vertex_size[at(v)]}; }

  void split_long_edges() {
    for (int sweep = 0; sweep < 6; ++sweep) {
      std::vector<std::pair<double, int>> edges;
      for (int h = 0; h < m_mesh.half_edges(); ++h)
        if (m_mesh.is_alive(h) && h < m_mesh.twin(h) && relative_length(h) > TOO_LONG)
          edges.emplace_back(-m_mesh.length(h), h);
      std::sort(edges.begin(), edges.end());
      for (const auto& [length, h] : edges) {
        if (relative_length(h) <= TOO_LONG)
          continue;
        const Vec3 middle = (m_mesh.point(m_mesh.from(h)) + m_mesh.point(m_mesh.to(h))) / 2;
        const Vec3 normal = m_mesh.normal(h / 3) + m_mesh.normal(m_mesh.twin(h) / 3);
        const double size = wanted_length(m_mesh.from(h), m_mesh.to(h));
        const Target target =
            m_mesh.is_feature(h) ? put_on_line(middle, size) : put_back(middle, normal, {middle, size});
        m_mesh.split(h, target.point);
        m_is_corner.push_back(0);
        m_vertex_size.push_back(target.size);
      }
      if (edges.empty())
        return;
    }
  }

  void collapse_short_edges() {
    for (int h = 0; h < m_mesh.half_edges(); ++h) {
      if (!m_mesh.is_alive(h) || relative_length(h) >= TOO_SHORT)
        continue;
      try_collapse(h);
    }
  }

  void try_collapse(int h) {
    const int a = m_mesh.from(h);
    const int b = m_mesh.to(h);
    const std::vector<int> lines_a = feature_neighbours(a);
    const std::vector<int> lines_b = feature_neighbours(b);
    if (m_is_corner[at(a)] || (!lines_a.empty() && !m_mesh.is_feature(h)) || !m_mesh.can_collapse(h))
      return;
    Target target = now(b);
    const Vec3 middle = (m_mesh.point(a) + m_mesh.point(b)) / 2;
    if (!m_is_corner[at(b)] && !lines_a.empty())
      target = put_on_line(middle, wanted_length(a, b));
    else if (!m_is_corner[at(b)] && lines_b.empty())
      target = put_back(middle, vertex_normal(a) + vertex_normal(b), target);
    if (!keeps_shape(a, b, target) || !keeps_shape(b, a, target))
      return;
    m_mesh.collapse(h);
    m_mesh.point(b) = target.point;
    m_vertex_size[at(b)] = target.size;
  }

  /// Whether moving v to `target` turns no triangle around it over, or draws an edge too long; triangles with `other`
  /// vanish.
  bool keeps_shape(int v, int other, const Target& place) const {
    bool keeps = true;
    const Vec3& target = place.point;
    for_each_out(m_mesh, v, [&](int h) {
      const int b = m_mesh.to(h);
      const int c = m_mesh.apex(h);
      if (b != other && (m_mesh.point(b) - target).norm() > TOO_LONG * (place.size + m_vertex_size[at(b)]) / 2)
        keeps = false;
      if (b == other || c == other)
        return;
      const Vec3 before = m_mesh.normal(h / 3);
      const Vec3 after = (m_mesh.point(b) - target).cross(m_mesh.point(c) - target);
      const double longest =
          std::max({(m_mesh.point(b) - target).squaredNorm(), (m_mesh.point(c) - target).squaredNorm(),
                    (m_mesh.point(c) - m_mesh.point(b)).squaredNorm()});
      if (after.dot(before) < 0.5 * after.norm() * before.norm() || after.norm() < 0.1 * longest)
        keeps = false;
    });
    return keeps;
  }

  int wanted_valence_excess(int v, int change) const { return m_mesh.valence(v) + change - 6; }

  /// Whether the two triangles of an edge stay upright when it is flipped.
  bool may_flip(int h) const {
    if (m_mesh.is_feature(h))
      return false;
    const int t = m_mesh.twin(h);
    const Vec3& a = m_mesh.point(m_mesh.from(h));
    const Vec3& b = m_mesh.point(m_mesh.to(h));
    const Vec3& c = m_mesh.point(m_mesh.apex(h));
    const Vec3& d = m_mesh.point(m_mesh.apex(t));
    const Vec3 n1 = (d - a).cross(c - a);
    const Vec3 n2 = (c - b).cross(d - b);
    const Vec3 before = m_mesh.normal(h / 3) + m_mesh.normal(t / 3);
    return n1.dot(n2) > 0.5 * n1.norm() * n2.norm() && n1.dot(before) > 0.5 * n1.norm() * before.norm() &&
           n2.dot(before) > 0.5 * n2.norm() * before.norm() && n1.norm() > 0.2 * (d - c).squaredNorm() * 0.5 &&
           n2.norm() > 0.2 * (d - c).squaredNorm() * 0.5;
  }

  void flip_edges() {
    for (int h = 0; h < m_mesh.half_edges(); ++h) {
      if (!m_mesh.is_alive(h) || h > m_mesh.twin(h))
        continue;
      const std::array<int, 4> corners{m_mesh.from(h), m_mesh.to(h), m_mesh.apex(h), m_mesh.apex(m_mesh.twin(h))};
      int gain = 0;
      for (int k = 0; k < 4; ++k) {
        const int now = wanted_valence_excess(corners[k], 0);
        const int then = wanted_valence_excess(corners[k], k < 2 ? -1 : 1);
        gain += now * now - then * then;
      }
      if (gain > 0 && may_flip(h))
        m_mesh.flip(h);
    }
  }

  double angle_opposite(int h) const {
    const Vec3& apex = m_mesh.point(m_mesh.apex(h));
    return angle_between(m_mesh.point(m_mesh.from(h)) - apex, m_mesh.point(m_mesh.to(h)) - apex);
  }

  void flip_to_delaunay() {
    for (int sweep = 0; sweep < 3; ++sweep)
      for (int h = 0; h < m_mesh.half_edges(); ++h)
        if (m_mesh.is_alive(h) && h < m_mesh.twin(h) &&
            angle_opposite(h) + angle_opposite(m_mesh.twin(h)) > M_PI * 1.02 && may_flip(h))
          m_mesh.flip(h);
  }

  /// The greatest turn over the diagonal a b and the four sides of the pair of triangles a b c and b a d.
  double greatest_turn(int a, int b, int c, int d, const std::array<Vec3, 4>& side_normals) const {
    const Vec3& x = m_mesh.point(a);
    const Vec3& y = m_mesh.point(b);
    const Vec3 first = (y - x).cross(m_mesh.point(c) - x);
    const Vec3 second = (x - y).cross(m_mesh.point(d) - y);
    // Sides b c, c a belong to the first triangle, a d, d b to the second.
    return std::max({angle_between(first, second), angle_between(first, side_normals[0]),
                     angle_between(first, side_normals[1]), angle_between(second, side_normals[2]),
                     angle_between(second, side_normals[3])});
  }

  /// Whether a triangle of these vertices would be neither thin (its height at least .3 of its longest edge) nor large.
  bool is_well_shaped(int a, int b, int c) const {
    const Vec3 u = m_mesh.point(b) - m_mesh.point(a);
    const Vec3 v = m_mesh.point(c) - m_mesh.point(a);
    const double longest = std::max({u.squaredNorm(), v.squaredNorm(), (u - v).squaredNorm()});
    const double limit = TOO_LONG * std::max({m_vertex_size[at(a)], m_vertex_size[at(b)], m_vertex_size[at(c)]});
    return u.cross(v).norm() > 0.3 * longest && longest < limit * limit;
  }

  /// Flips edges across which the mesh folds more than the surface does.
  void flip_folds() {
    constexpr double FOLD = 60 * RADIANS;
    constexpr double GAIN = 5 * RADIANS;
    for (int sweep = 0; sweep < 4; ++sweep) {
      for (int h = 0; h < m_mesh.half_edges(); ++h) {
        if (!m_mesh.is_alive(h) || h > m_mesh.twin(h) || m_mesh.is_feature(h))
          continue;
        const int t = m_mesh.twin(h);
        const auto across = [&](int side) { return m_mesh.normal(m_mesh.twin(side) / 3); };
        const std::array<Vec3, 4> n{across(HalfEdgeMesh::next(h)), across(HalfEdgeMesh::previous(h)),
                                    across(HalfEdgeMesh::next(t)), across(HalfEdgeMesh::previous(t))};
        const int a = m_mesh.from(h);
        const int b = m_mesh.to(h);
        const int c = m_mesh.apex(h);
        const int d = m_mesh.apex(t);
        const double before = greatest_turn(a, b, c, d, n);
        // After the flip d c a has the sides c a, a d, and c d b the sides d b, b c.
        const double after = greatest_turn(d, c, a, b, {n[1], n[2], n[3], n[0]});
        if (before > FOLD && after < before - GAIN && is_well_shaped(d, c, a) && is_well_shaped(c, d, b))
          m_mesh.flip(h);
      }
    }
  }

  /// Moves vertices along the surface towards the middle of their triangles.
  void smooth() {
    for (int sweep = 0; sweep < 2; ++sweep)
      for (int v = 0; v < m_mesh.vertices(); ++v)
        if (m_mesh.is_vertex_alive(v) && !m_is_corner[at(v)])
          smooth_vertex(v);
  }

  void smooth_vertex(int v) {
    const std::vector<int> lines = feature_neighbours(v);
    Target target = now(v);
    if (lines.size() == 2) {
      target.point = m_lines->closest((m_mesh.point(lines[0]) + m_mesh.point(lines[1])) / 2).point;
    } else if (lines.empty()) {
      target = put_back(relaxed(v), vertex_normal(v), target);
    } else {
      return;
    }
    if (stays_upright(v, target.point)) {
      m_mesh.point(v) = target.point;
      m_vertex_size[at(v)] = target.size;
    }
  }

  Vec3 relaxed(int v) const {
    Vec3 sum = Vec3::Zero();
    double weights = 0;
    for_each_out(m_mesh, v, [&](int h) {
      const Vec3 centre = (m_mesh.point(v) + m_mesh.point(m_mesh.to(h)) + m_mesh.point(m_mesh.apex(h))) / 3;
      const double size =
          (m_vertex_size[at(v)] + m_vertex_size[at(m_mesh.to(h))] + m_vertex_size[at(m_mesh.apex(h))]) / 3;
      const double weight = m_mesh.normal(h / 3).norm() / (size * size);
      sum += weight * centre;
      weights += weight;
    });
    const Vec3 step = sum / weights - m_mesh.point(v);
    const Vec3 normal = vertex_normal(v);
    return m_mesh.point(v) + step - step.dot(normal) * normal;
  }

  bool stays_upright(int v, const Vec3& target) const {
    bool upright = true;
    for_each_out(m_mesh, v, [&](int h) {
      const Vec3 before = m_mesh.normal(h / 3);
      const Vec3 after = (m_mesh.point(m_mesh.to(h)) - target).cross(m_mesh.point(m_mesh.apex(h)) - target);
      upright = upright && after.dot(before) > 0.5 * after.norm() * before.norm();
    });
    return upright;
  }

  RemeshSettings m_settings;
  HalfEdgeMesh m_mesh;
  ClosestPointTree m_tree;
  std::optional<ClosestPointTree> m_lines;
  std::vector<char> m_is_corner;
  std::vector<double> m_vertex_size; ///< wanted edge at the vertices as they are now [m]
  std::vector<double> m_sizes;       ///< wanted edge at the vertices of the original surface [m]
};

} // namespace

Result<SurfaceMesh> remesh(const SurfaceMesh& surface, const RemeshSettings& settings) {
  if (!(settings.edge > 0) || !std::isfinite(settings.edge))
    return make_error(ErrorCode::bad_input, "the target edge is {} m; it must be positive", settings.edge);
  Result<HalfEdgeMesh> mesh = HalfEdgeMesh::from_surface(surface);
  if (!mesh)
    return mesh.error();
  return Remesher(surface, *std::move(mesh), settings).run();
}

Result<SurfaceMesh> remesh(const SurfaceMesh& surface, double edge) {
  RemeshSettings settings;
  settings.edge = edge;
  return remesh(surface, settings);
}

} // namespace wry::geometry
