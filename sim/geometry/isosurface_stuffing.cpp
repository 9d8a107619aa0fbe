#include "sim/geometry/isosurface_stuffing.h"

#include <array>
#include <cmath>
#include <unordered_map>
#include <vector>

#include <Eigen/Geometry>

#include "sim/geometry/prism_split.h"

namespace wry::geometry {

namespace {

using Id = std::int64_t;
using Step = std::array<int, 3>;

/// A cut closer to a lattice vertex than this share of the edge pulls the vertex onto the surface (table 1 of the
/// paper).
constexpr double SNAP_LONG = 0.24999;
constexpr double SNAP_SHORT = 0.41189;

constexpr std::array<Step, 7> DIRECTIONS{
    {{2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {1, 1, 1}, {-1, 1, 1}, {1, -1, 1}, {1, 1, -1}}};

bool is_long(int direction) {
  return direction < 3;
}

/// The BCC lattice in half-cell steps: points with all coordinates even, or all odd.
class Lattice {
public:
  Lattice(const Bounds& bounds, double cell)
      : m_half(cell / 2) {
    const Vec3 middle = (bounds.low + bounds.high) / 2;
    for (int k = 0; k < 3; ++k) {
      const double extent = bounds.high[k] - bounds.low[k];
      m_cells[k] = std::max<Id>(1, static_cast<Id>(std::ceil(extent / cell))) + 2;
      m_size[k] = 2 * m_cells[k] + 1;
      m_origin[k] = middle[k] - static_cast<double>(m_cells[k]) * m_half;
    }
  }

  Id size() const { return m_size[0] * m_size[1] * m_size[2]; }
  Id cells(int axis) const { return m_cells[axis]; }
  Id id(Id i, Id j, Id k) const { return (i * m_size[1] + j) * m_size[2] + k; }
  std::array<Id, 3> coordinates(Id id) const {
    return {id / (m_size[1] * m_size[2]), id / m_size[2] % m_size[1], id % m_size[2]};
  }
  static bool holds(const std::array<Id, 3>& c) { return (c[0] & 1) == (c[1] & 1) && (c[1] & 1) == (c[2] & 1); }
  Vec3 position(Id id) const {
    const auto c = coordinates(id);
    return m_origin + m_half * Vec3(static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2]));
  }
  /// The neighbour at `sign` times a direction, or -1 outside.
  Id neighbour(Id id, int direction, int sign) const {
    const auto c = coordinates(id);
    std::array<Id, 3> n{};
    for (int k = 0; k < 3; ++k) {
      n[k] = c[k] + sign * DIRECTIONS[direction][k];
      if (n[k] < 0 || n[k] >= m_size[k])
        return -1;
    }
    return this->id(n[0], n[1], n[2]);
  }
  /// The direction that leads from one lattice point to its neighbour, or back.
  int direction_between(Id a, Id b) const {
    const auto p = coordinates(a);
    const auto q = coordinates(b);
    for (int d = 0; d < 7; ++d) {
      const Step& s = DIRECTIONS[d];
      if ((q[0] - p[0] == s[0] && q[1] - p[1] == s[1] && q[2] - p[2] == s[2]) ||
          (p[0] - q[0] == s[0] && p[1] - q[1] == s[1] && p[2] - q[2] == s[2]))
        return d;
    }
    return -1;
  }

private:
  double m_half;
  std::array<Id, 3> m_cells{};
  std::array<Id, 3> m_size{};
  Vec3 m_origin;
};

class Stuffing {
public:
  Stuffing(const DistanceFunction& distance, const Bounds& bounds, double level, double cell)
      : m_distance(distance)
      , m_level(level)
      , m_lattice(bounds, cell) {}

  TetMesh run() {
    sample();
    find_cuts();
    snap();
    for (Id i = 0; i < m_lattice.cells(0); ++i)
      for (Id j = 0; j < m_lattice.cells(1); ++j)
        for (Id k = 0; k < m_lattice.cells(2); ++k)
          emit_around({2 * i + 1, 2 * j + 1, 2 * k + 1});
    return finish();
  }

private:
  double depth(const Vec3& x) const { return m_level - m_distance(x); } ///< positive inside

  void sample() {
    m_depth.assign(static_cast<std::size_t>(m_lattice.size()), -1.0F);
    for (Id id = 0; id < m_lattice.size(); ++id) {
      if (Lattice::holds(m_lattice.coordinates(id)))
        m_depth[at(id)] = static_cast<float>(depth(m_lattice.position(id)));
    }
  }

  static std::size_t at(Id id) { return static_cast<std::size_t>(id); }
  static int sign(float depth) { return depth > 0 ? 1 : depth < 0 ? -1 : 0; }
  static std::uint64_t key(Id from, int direction) {
    return static_cast<std::uint64_t>(from) * 8 + static_cast<unsigned>(direction);
  }

  /// Share of the way from a to b at which the depth vanishes: regula falsi with the Illinois rule.
  double root(const Vec3& a, const Vec3& b, double depth_a, double depth_b) const {
    double low = 0;
    double high = 1;
    double t = depth_a / (depth_a - depth_b);
    for (int i = 0; i < 6; ++i) {
      const double value = depth(a + t * (b - a));
      if (value * depth_a > 0) {
        low = t;
        depth_a = value;
        depth_b *= i > 0 ? 0.5 : 1.0;
      } else if (value * depth_b > 0) {
        high = t;
        depth_b = value;
        depth_a *= i > 0 ? 0.5 : 1.0;
      } else {
        return t;
      }
      t = low + (high - low) * depth_a / (depth_a - depth_b);
    }
    return std::clamp(t, 1e-6, 1 - 1e-6);
  }

  void find_cuts() {
    for (Id id = 0; id < m_lattice.size(); ++id) {
      const int here = sign(m_depth[at(id)]);
      if (here == 0 || !Lattice::holds(m_lattice.coordinates(id)))
        continue;
      for (int d = 0; d < 7; ++d) {
        const Id other = m_lattice.neighbour(id, d, 1);
        if (other < 0 || sign(m_depth[at(other)]) * here >= 0)
          continue;
        m_cuts.emplace(key(id, d), root(m_lattice.position(id), m_lattice.position(other),
                                        static_cast<double>(m_depth[at(id)]), static_cast<double>(m_depth[at(other)])));
        if (m_active.empty() || m_active.back() != id)
          m_active.push_back(id);
      }
    }
  }

  /// Moves a vertex that a cut comes too close to onto the nearest such cut.
  void snap() {
    std::vector<Id> touched;
    for (const Id id : m_active) {
      touched.push_back(id);
      for (int d = 0; d < 7; ++d)
        if (m_cuts.contains(key(id, d)))
          touched.push_back(m_lattice.neighbour(id, d, 1));
    }
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    for (const Id id : touched)
      snap_vertex(id);
  }

  void snap_vertex(Id id) {
    if (m_depth[at(id)] == 0.0F)
      return;
    const Vec3 here = m_lattice.position(id);
    double nearest = std::numeric_limits<double>::infinity();
    Vec3 target = here;
    for (int d = 0; d < 7; ++d) {
      for (const int side : {1, -1}) {
        const Id other = m_lattice.neighbour(id, d, side);
        if (other < 0 || sign(m_depth[at(other)]) * sign(m_depth[at(id)]) >= 0)
          continue;
        const double from_first = m_cuts.at(side > 0 ? key(id, d) : key(other, d));
        const double share = side > 0 ? from_first : 1 - from_first;
        const Vec3 offset = share * (m_lattice.position(other) - here);
        if (share < (is_long(d) ? SNAP_LONG : SNAP_SHORT) && offset.norm() < nearest) {
          nearest = offset.norm();
          target = here + offset;
        }
      }
    }
    if (std::isfinite(nearest)) {
      m_depth[at(id)] = 0.0F;
      m_moved.emplace(id, target);
    }
  }

  /// The tets of the cell centre `c` towards its neighbours along +x, +y and +z: four around each shared face.
  void emit_around(const std::array<Id, 3>& c) {
    for (int axis = 0; axis < 3; ++axis) {
      if (c[axis] / 2 + 1 >= m_lattice.cells(axis))
        continue;
      std::array<Id, 3> next = c;
      next[axis] += 2;
      const int u = (axis + 1) % 3;
      const int v = (axis + 2) % 3;
      const auto corner = [&](int du, int dv) {
        std::array<Id, 3> p = c;
        p[axis] += 1;
        p[u] += du;
        p[v] += dv;
        return m_lattice.id(p[0], p[1], p[2]);
      };
      const std::array<Id, 4> ring{corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)};
      for (int k = 0; k < 4; ++k)
        emit({m_lattice.id(c[0], c[1], c[2]), m_lattice.id(next[0], next[1], next[2]), ring[k], ring[(k + 1) % 4]});
    }
  }

  /// The part of a lattice tet that lies inside, by the stencils of the paper's figure 3.
  void emit(const std::array<Id, 4>& tet) {
    std::vector<Id> inside, on, outside;
    for (const Id id : tet) {
      const int s = sign(m_depth[at(id)]);
      (s > 0 ? inside : s == 0 ? on : outside).push_back(id);
    }
    if (inside.empty())
      return;
    if (outside.empty()) {
      add({vertex(tet[0]), vertex(tet[1]), vertex(tet[2]), vertex(tet[3])});
    } else if (inside.size() == 1) {
      std::array<std::int32_t, 4> corners{vertex(inside[0])};
      std::size_t n = 1;
      for (const Id id : on)
        corners[n++] = vertex(id);
      for (const Id id : outside)
        corners[n++] = cut(inside[0], id);
      add(corners);
    } else if (inside.size() == 2 && on.size() == 1) {
      const std::int32_t apex = vertex(on[0]);
      const Id a = inside[0];
      const Id b = inside[1];
      const Id o = outside[0];
      if (diagonal_from_first(a, b, o)) {
        add({apex, vertex(a), vertex(b), cut(b, o)});
        add({apex, vertex(a), cut(b, o), cut(a, o)});
      } else {
        add({apex, vertex(a), vertex(b), cut(a, o)});
        add({apex, vertex(b), cut(b, o), cut(a, o)});
      }
    } else if (inside.size() == 2) {
      emit_wedge(inside[0], inside[1], outside[0], outside[1]);
    } else {
      emit_truncated(inside, outside[0]);
    }
  }

  void emit_truncated(const std::vector<Id>& inside, Id o) {
    Prism prism{};
    std::array<Diagonal, 3> sides{};
    for (int i = 0; i < 3; ++i) {
      prism.top[i] = vertex(inside[i]);
      prism.bottom[i] = cut(inside[i], o);
      sides[i] = diagonal_from_first(inside[i], inside[(i + 1) % 3], o) ? Diagonal::down : Diagonal::up;
    }
    for (const auto& t : split_prism(prism, sides))
      add(t);
  }

  void emit_wedge(Id a, Id b, Id o, Id p) {
    const Prism prism{{vertex(a), cut(a, o), cut(a, p)}, {vertex(b), cut(b, o), cut(b, p)}};
    const auto length = [&](std::int32_t i, std::int32_t j) { return (m_points[at(i)] - m_points[at(j)]).norm(); };
    std::array<Diagonal, 3> sides{};
    sides[0] = diagonal_from_first(a, b, o) ? Diagonal::down : Diagonal::up;
    sides[2] = diagonal_from_first(a, b, p) ? Diagonal::up : Diagonal::down; // side 2 runs from column 2 to column 0
    sides[1] =
        length(prism.top[1], prism.bottom[2]) <= length(prism.bottom[1], prism.top[2]) ? Diagonal::down : Diagonal::up;
    if (!is_splittable(sides))
      sides[1] = sides[1] == Diagonal::down ? Diagonal::up : Diagonal::down;
    for (const auto& t : split_prism(prism, sides))
      add(t);
  }

  /// Whether the quadrilateral a, b, cut(b, o), cut(a, o) is divided from a to cut(b, o), rather than from b to cut(a,
  /// o). Of a long and a short cut edge the diagonal takes the cut of the long one; of two short ones any fixed rule
  /// serves.
  bool diagonal_from_first(Id a, Id b, Id o) const {
    const bool a_long = is_long(m_lattice.direction_between(a, o));
    const bool b_long = is_long(m_lattice.direction_between(b, o));
    if (a_long != b_long)
      return b_long;
    const auto p = m_lattice.coordinates(a);
    const auto q = m_lattice.coordinates(b);
    int greater = 0;
    for (int k = 0; k < 3; ++k)
      greater += p[k] > q[k] ? 1 : 0;
    return greater % 2 == 1;
  }

  std::int32_t vertex(Id id) {
    const auto [entry, is_new] = m_vertex_of.emplace(id, static_cast<std::int32_t>(m_points.size()));
    if (is_new) {
      const auto moved = m_moved.find(id);
      m_points.push_back(moved != m_moved.end() ? moved->second : m_lattice.position(id));
    }
    return entry->second;
  }

  std::int32_t cut(Id a, Id b) {
    const int d = m_lattice.direction_between(a, b);
    const bool forward = m_lattice.neighbour(a, d, 1) == b;
    const Id from = forward ? a : b;
    const Id to = forward ? b : a;
    const auto [entry, is_new] = m_vertex_of_cut.emplace(key(from, d), static_cast<std::int32_t>(m_points.size()));
    if (is_new) {
      const Vec3 x = m_lattice.position(from);
      m_points.push_back(x + m_cuts.at(key(from, d)) * (m_lattice.position(to) - x));
    }
    return entry->second;
  }

  void add(std::array<std::int32_t, 4> t) {
    const Vec3& x = m_points[at(t[0])];
    if ((m_points[at(t[1])] - x).cross(m_points[at(t[2])] - x).dot(m_points[at(t[3])] - x) < 0)
      std::swap(t[2], t[3]);
    m_tets.push_back(t);
  }

  TetMesh finish() const {
    TetMesh mesh;
    mesh.vertices.resize(static_cast<Eigen::Index>(m_points.size()), 3);
    for (std::size_t i = 0; i < m_points.size(); ++i)
      mesh.vertices.row(static_cast<Eigen::Index>(i)) = m_points[i].transpose();
    mesh.tets.resize(static_cast<Eigen::Index>(m_tets.size()), 4);
    for (std::size_t i = 0; i < m_tets.size(); ++i)
      for (int k = 0; k < 4; ++k)
        mesh.tets(static_cast<Eigen::Index>(i), k) = m_tets[i][k];
    return mesh;
  }

  const DistanceFunction& m_distance;
  double m_level;
  Lattice m_lattice;
  std::vector<float> m_depth; ///< per lattice point, zero once it lies on the surface
  std::unordered_map<std::uint64_t, double> m_cuts;
  std::vector<Id> m_active;
  std::unordered_map<Id, Vec3> m_moved;
  std::unordered_map<Id, std::int32_t> m_vertex_of;
  std::unordered_map<std::uint64_t, std::int32_t> m_vertex_of_cut;
  std::vector<Vec3> m_points;
  std::vector<std::array<std::int32_t, 4>> m_tets;
};

} // namespace

Result<TetMesh> stuff_isosurface(const DistanceFunction& distance, const Bounds& bounds, double level,
                                 const StuffingSettings& settings) {
  if (!(settings.edge > 0))
    return make_error(ErrorCode::bad_input, "the target edge is {} m; it must be positive", settings.edge);
  const Vec3 cells = (bounds.high - bounds.low) / settings.edge;
  const double points = 8 * (cells.array() + 3).prod();
  if (!(points <= static_cast<double>(settings.max_lattice)))
    return make_error(ErrorCode::bad_input,
                      "an edge of {:.4g} m needs {:.3g} lattice points for a body of {:.4g} x {:.4g} x {:.4g} m, the "
                      "limit is {:.3g}. Try a larger `resolution`, or a `shell`.",
                      settings.edge, points, bounds.high.x() - bounds.low.x(), bounds.high.y() - bounds.low.y(),
                      bounds.high.z() - bounds.low.z(), static_cast<double>(settings.max_lattice));
  TetMesh mesh = Stuffing(distance, bounds, level, settings.edge).run();
  return mesh;
}

} // namespace wry::geometry
