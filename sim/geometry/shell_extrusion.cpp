#include "sim/geometry/shell_extrusion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>

#include "sim/geometry/closest_point_tree.h"
#include "sim/geometry/mesh_checks.h"
#include "sim/geometry/remesh.h"
#include "sim/geometry/shell_extrusion_layers.h"
#include "sim/geometry/signed_distance_volume.h"

namespace wry::geometry {

namespace {

/// A cavity must be this much deeper than the wall, so that its two sides keep apart.
constexpr double CAVITY_MARGIN = 1.2;
/// Wall of a thin place as a share of the depth there.
constexpr double THIN_SHARE = 0.7;
/// Walls grow back from a thin place by this much per length along the surface.
constexpr double THIN_GRADING = 0.3;
/// How often walls whose inner sides cross are made thinner by this share.
constexpr int CROSSING_ATTEMPTS = 4;
constexpr double CROSSING_SHRINK = 0.75;
/// Margin over the gate's limits that is worked for, and the sweeps spent on it.
constexpr double WANTED_MARGIN = 1.5;
constexpr int SWEEPS = 8;
/// Shares of the finest edge and of the turn per edge that are tried in turn.
constexpr std::array<double, 3> REFINEMENTS{1.0, 0.7, 0.5};

class Extrusion {
public:
  Extrusion(const SurfaceMesh& surface, const SurfaceMesh& outer, const ShellSettings& settings)
      : m_settings(settings)
      , m_tree(surface)
      , m_triangles(outer.triangles)
      , m_outer(outer.vertices)
      , m_neighbours(static_cast<std::size_t>(outer.vertices.rows())) {
    for (Eigen::Index t = 0; t < m_triangles.rows(); ++t)
      for (int k = 0; k < 3; ++k)
        m_neighbours[at(m_triangles(t, k))].push_back(m_triangles(t, (k + 1) % 3));
    make_directions();
    fit_outer();
    measure_depths();
  }

  /// Errors: bad_input naming the thinnest place, if there is one that the wall does not fit in.
  Status check_depths() const {
    const double needed = CAVITY_MARGIN * m_settings.thickness;
    const std::size_t worst = at(std::min_element(m_depth.begin(), m_depth.end()) - m_depth.begin());
    if (m_depth[worst] >= needed)
      return {};
    const auto short_of = std::count_if(m_depth.begin(), m_depth.end(), [&](double depth) { return depth < needed; });
    const Vec3 x = outer(static_cast<Eigen::Index>(worst));
    return make_error(ErrorCode::bad_input,
                      "a wall of {:.4g} m does not fit at ({:.4g}, {:.4g}, {:.4g}) m: the body is {:.4g} m deep there, "
                      "it needs {:.4g} m ({} of {} surface vertices). Try a thinner wall, or a thicker mesh.",
                      m_settings.thickness, x.x(), x.y(), x.z(), m_depth[worst], needed, short_of, m_depth.size());
  }

  ShellMesh run() {
    const Points fitted = m_outer;
    ShellMesh shell;
    for (int attempt = 0; attempt < CROSSING_ATTEMPTS; ++attempt) {
      m_outer = fitted;
      extrude();
      ShellLayers layers(m_triangles, m_outer, m_inner, m_settings.layers, m_settings.limits);
      layers.improve_diagonals();
      layers.improve_columns(
          WANTED_MARGIN, SWEEPS, [this](int column, const Vec3& x) { return onto_outer(column, x); },
          [this](int column, const Vec3& x) { return onto_inner(column, x); });
      m_outer = layers.outer();
      m_inner = layers.inner();
      shell.mesh = layers.tet_mesh();
      if (!thin_crossings(shell))
        break;
    }
    shell.columns = static_cast<int>(m_outer.rows());
    shell.outer_triangles = m_triangles;
    report(shell);
    return shell;
  }

private:
  static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }
  Vec3 outer(Eigen::Index column) const { return m_outer.row(column).transpose(); }
  Vec3 direction(Eigen::Index column) const { return m_directions.row(column).transpose(); }

  /// Inward directions: the angle-weighted normals of the new surface.
  void make_directions() { m_directions = -ClosestPointTree({m_outer, m_triangles, {}}).vertex_normals(); }

  /// Mean over the triangles around each vertex of the distance to a level set, at the corners' middles and the
  /// centres: how far the chords stand off the surface they stand for.
  std::vector<double> chord_errors(const Points& points, const std::vector<double>& level) const {
    std::vector<double> sum(at(points.rows()), 0.0);
    std::vector<double> weights(at(points.rows()), 0.0);
    for (Eigen::Index t = 0; t < m_triangles.rows(); ++t) {
      std::array<Vec3, 3> x;
      double wanted = 0;
      for (int k = 0; k < 3; ++k) {
        x[k] = points.row(m_triangles(t, k)).transpose();
        wanted += level[at(m_triangles(t, k))] / 3;
      }
      const double area = (x[1] - x[0]).cross(x[2] - x[0]).norm();
      // Exact for quadratic functions over a triangle: the three edges' middles.
      double error = 0;
      for (int k = 0; k < 3; ++k)
        error += (m_tree.signed_distance((x[k] + x[(k + 1) % 3]) / 2) - wanted) / 3;
      for (int k = 0; k < 3; ++k) {
        sum[at(m_triangles(t, k))] += area * error;
        weights[at(m_triangles(t, k))] += area;
      }
    }
    for (std::size_t i = 0; i < sum.size(); ++i)
      sum[i] /= weights[i];
    return sum;
  }

  /// Lifts vertices a little off the surface so that the flat triangles enclose its volume.
  void fit_outer() {
    const std::vector<double> level(at(m_outer.rows()), 0.0);
    m_lift.assign(at(m_outer.rows()), 0.0);
    for (int pass = 0; pass < 3; ++pass) {
      const std::vector<double> error = chord_errors(m_outer, level);
      for (Eigen::Index i = 0; i < m_outer.rows(); ++i) {
        const double lift =
            std::clamp(m_lift[at(i)] - error[at(i)], -0.25 * m_settings.thickness, 0.25 * m_settings.thickness);
        m_outer.row(i) -= (lift - m_lift[at(i)]) * m_directions.row(i);
        m_lift[at(i)] = lift;
      }
    }
  }

  /// The largest depth below each vertex, up to what the wall needs, and the wall that fits.
  void measure_depths() {
    const double needed = CAVITY_MARGIN * m_settings.thickness;
    m_depth.assign(at(m_outer.rows()), 0.0);
    m_wall.assign(at(m_outer.rows()), m_settings.thickness);
    for (Eigen::Index i = 0; i < m_outer.rows(); ++i) {
      m_depth[at(i)] = straight_depth(i, needed);
      if (m_depth[at(i)] < needed)
        lean_column(i, needed);
      if (m_depth[at(i)] < needed)
        m_wall[at(i)] = std::min(m_settings.thickness, THIN_SHARE * m_depth[at(i)]);
    }
    grade_walls();
  }

  double straight_depth(Eigen::Index i, double needed) const {
    const double step = m_settings.thickness / 8;
    double depth = -m_tree.signed_distance(outer(i));
    for (double s = step; s < 3 * needed && depth < needed; s += step) {
      const double here = -m_tree.signed_distance(outer(i) + s * direction(i));
      if (here < depth)
        break;
      depth = here;
    }
    return depth;
  }

  /// Follows the slope of the distance where a straight column does not get deep enough, as near the corner of a box;
  /// if that does, the column leans that way.
  void lean_column(Eigen::Index i, double needed) {
    const double step = m_settings.thickness / 8;
    Vec3 x = outer(i);
    Vec3 at_wall = x;
    double depth = -m_tree.signed_distance(x);
    double greatest = depth;
    for (int k = 0; k < 64 && depth < needed; ++k) {
      Vec3 slope;
      for (int axis = 0; axis < 3; ++axis)
        slope[axis] =
            m_tree.signed_distance(x + step * Vec3::Unit(axis)) - m_tree.signed_distance(x - step * Vec3::Unit(axis));
      if (slope.norm() < 0.2 * step)
        break;
      x -= step * slope.normalized();
      depth = -m_tree.signed_distance(x);
      if (depth < greatest - 0.5 * step)
        break;
      greatest = std::max(greatest, depth);
      if (depth <= m_settings.thickness)
        at_wall = x;
    }
    m_depth[at(i)] = std::max(m_depth[at(i)], greatest);
    if (greatest >= needed && at_wall != outer(i))
      m_directions.row(i) = (at_wall - outer(i)).normalized().transpose();
  }

  void grade_walls() {
    for (int sweep = 0; sweep < 50; ++sweep)
      for (Eigen::Index i = 0; i < m_outer.rows(); ++i)
        for (const std::int32_t j : m_neighbours[at(i)])
          m_wall[at(j)] = std::min(m_wall[at(j)], m_wall[at(i)] + THIN_GRADING * (outer(i) - outer(j)).norm());
  }

  /// Finds where the boundary of the shell cuts itself, and thins the walls whose inner sides do. Returns whether there
  /// is anything to try again.
  bool thin_crossings(ShellMesh& shell) {
    const auto inner_begin = static_cast<std::int32_t>(m_settings.layers * m_outer.rows());
    SurfaceMesh boundary{shell.mesh.vertices, Triangles(2 * m_triangles.rows(), 3), {}};
    boundary.triangles.topRows(m_triangles.rows()) = m_triangles;
    for (int k = 0; k < 3; ++k)
      boundary.triangles.col(k).tail(m_triangles.rows()) = m_triangles.col(2 - k).array() + inner_begin;
    const SelfIntersections crossings = find_self_intersections(boundary, Threads(1));
    shell.self_intersections = static_cast<std::int64_t>(crossings.pairs.size());
    std::vector<Eigen::Index> columns;
    for (const auto& [first, second] : crossings.pairs) {
      if (columns.empty())
        shell.self_intersection_point = boundary.vertices.row(boundary.triangles(first, 0)).transpose();
      for (const std::int32_t triangle : {first, second})
        for (int k = 0; k < 3 && triangle >= m_triangles.rows(); ++k)
          columns.push_back(boundary.triangles(triangle, k) - inner_begin);
    }
    std::sort(columns.begin(), columns.end());
    columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
    for (const Eigen::Index column : columns)
      m_wall[at(column)] *= CROSSING_SHRINK;
    grade_walls();
    return !columns.empty();
  }

  /// Places the inner vertices along the columns where the depth equals the wall, then lets chords stand for curves.
  void extrude() {
    m_inner.resize(m_outer.rows(), 3);
    std::vector<double> level(at(m_outer.rows()));
    std::vector<double> target(at(m_outer.rows()));
    for (Eigen::Index i = 0; i < m_outer.rows(); ++i) {
      target[at(i)] = level[at(i)] = -m_wall[at(i)];
      m_inner.row(i) = along_column(i, target[at(i)]).transpose();
    }
    for (int pass = 0; pass < 2; ++pass) {
      const std::vector<double> error = chord_errors(m_inner, level);
      for (Eigen::Index i = 0; i < m_outer.rows(); ++i) {
        const double limit = 0.15 * m_wall[at(i)];
        target[at(i)] = std::clamp(target[at(i)] - error[at(i)], level[at(i)] - limit, level[at(i)] + limit);
        m_inner.row(i) = along_column(i, target[at(i)]).transpose();
      }
    }
    m_inner_level = target;
  }

  /// The first point of a column at a level of the signed distance; its deepest point if it does not reach the level.
  Vec3 along_column(Eigen::Index i, double level) const {
    const double step = m_settings.thickness / 6;
    double low = 0;
    double value_low = m_tree.signed_distance(outer(i));
    for (double s = step; s < 6 * m_settings.thickness; s += step) {
      const double value = m_tree.signed_distance(outer(i) + s * direction(i));
      if (value <= level)
        return outer(i) + root(i, level, low, s, value_low, value) * direction(i);
      if (value > value_low)
        return outer(i) + low * direction(i);
      low = s;
      value_low = value;
    }
    return outer(i) + low * direction(i);
  }

  double root(Eigen::Index i, double level, double low, double high, double value_low, double value_high) const {
    double s = high;
    for (int k = 0; k < 20; ++k) {
      s = low + (high - low) * (value_low - level) / std::max(value_low - value_high, 1e-30);
      const double value = m_tree.signed_distance(outer(i) + s * direction(i));
      if (std::abs(value - level) < 1e-9 * m_settings.thickness)
        break;
      (value > level ? low : high) = s;
      (value > level ? value_low : value_high) = value;
    }
    return s;
  }

  /// Whether a place of the surface faces the way the column came from, and is not the other side of a thin wall.
  bool is_own_side(int column, const ClosestPoint& place) const {
    return m_tree.smooth_normal(place).dot(direction(column)) < -0.1;
  }

  std::optional<Vec3> onto_outer(int column, const Vec3& x) const {
    const ClosestPoint nearest = m_tree.closest(x);
    if (!is_own_side(column, nearest))
      return std::nullopt;
    return nearest.point + m_lift[at(column)] * m_tree.smooth_normal(nearest);
  }

  std::optional<Vec3> onto_inner(int column, Vec3 x) const {
    for (int k = 0; k < 4; ++k) {
      const ClosestPoint nearest = m_tree.closest(x);
      if (!is_own_side(column, nearest))
        return std::nullopt;
      const Vec3 normal = m_tree.pseudonormal(nearest);
      const double value = (x - nearest.point).dot(normal) < 0 ? -nearest.distance : nearest.distance;
      const Vec3 gradient = nearest.distance > 0 ? Vec3((x - nearest.point) / value) : normal;
      x += (m_inner_level[at(column)] - value) * gradient;
    }
    return x;
  }

  void report(ShellMesh& shell) const {
    shell.quality = measure(shell.mesh);
    shell.min_wall = 1e300;
    for (Eigen::Index i = 0; i < m_inner.rows(); ++i) {
      const double wall = -m_tree.signed_distance(m_inner.row(i).transpose());
      shell.min_wall = std::min(shell.min_wall, wall);
      shell.max_wall = std::max(shell.max_wall, wall);
    }
    double sum = 0;
    for (Eigen::Index t = 0; t < m_triangles.rows(); ++t)
      for (int k = 0; k < 3; ++k)
        sum += (outer(m_triangles(t, k)) - outer(m_triangles(t, (k + 1) % 3))).norm();
    shell.mean_outer_edge = sum / static_cast<double>(3 * m_triangles.rows());
    find_thin_places(shell);
    shell.reference_volume = reference_volume();
    shell.volume_error = volume_error(shell.quality, shell.reference_volume);
  }

  /// Gathers columns whose body is too thin into connected places.
  void find_thin_places(ShellMesh& shell) const {
    const auto is_thin = [&](Eigen::Index i) { return m_wall[at(i)] < 0.999 * m_settings.thickness; };
    std::vector<char> seen(at(m_outer.rows()), 0);
    for (Eigen::Index start = 0; start < m_outer.rows(); ++start) {
      if (seen[at(start)] || !is_thin(start))
        continue;
      ThinPlace place;
      place.thickness = 1e300;
      std::vector<Eigen::Index> front{start};
      seen[at(start)] = 1;
      while (!front.empty()) {
        const Eigen::Index i = front.back();
        front.pop_back();
        ++place.columns;
        if (m_wall[at(i)] < place.thickness) {
          place.thickness = m_wall[at(i)];
          place.point = outer(i);
          place.depth = m_depth[at(i)];
        }
        for (const std::int32_t j : m_neighbours[at(i)]) {
          if (!seen[at(j)] && is_thin(j)) {
            seen[at(j)] = 1;
            front.push_back(j);
          }
        }
      }
      shell.thin_places.push_back(place);
    }
    std::stable_sort(shell.thin_places.begin(), shell.thin_places.end(),
                     [](const ThinPlace& a, const ThinPlace& b) { return a.thickness < b.thickness; });
    if (!shell.thin_places.empty())
      shell.method = ShellMethod::extruded_with_thinner_walls;
  }

  /// Of the wall between the surface and its offset; where walls are thinner, of the thinner wall.
  double reference_volume() const {
    const Points& x = m_tree.mesh().vertices;
    const Bounds bounds{x.colwise().minCoeff().transpose(), x.colwise().maxCoeff().transpose()};
    const double cell = m_settings.thickness / 2;
    const auto distance = [this](const Vec3& p) { return m_tree.signed_distance(p); };
    const bool uniform =
        std::all_of(m_wall.begin(), m_wall.end(), [&](double wall) { return wall == m_settings.thickness; });
    if (uniform)
      return volume_between(distance, bounds, -m_settings.thickness, 0.0, cell);
    const ClosestPointTree columns({m_outer, m_triangles, {}});
    // Depth measured in walls: the wall ends at the same value everywhere, and grows slowly enough to count as a
    // distance.
    const auto below_wall = [&](const Vec3& p) {
      const ClosestPoint nearest = columns.closest(p);
      double wall = 0;
      for (int k = 0; k < 3; ++k)
        wall += nearest.barycentric[k] * m_wall[at(m_triangles(nearest.triangle, k))];
      return (m_tree.signed_distance(p) + wall) / (1 + THIN_GRADING);
    };
    constexpr double EVERYTHING = 1e9;
    return volume_between(distance, bounds, -EVERYTHING, 0.0, cell) -
           volume_between(below_wall, bounds, -EVERYTHING, 0.0, cell);
  }

  ShellSettings m_settings;
  ClosestPointTree m_tree;
  Triangles m_triangles;
  Points m_outer;
  Points m_inner;
  Points m_directions;
  std::vector<std::vector<std::int32_t>> m_neighbours;
  std::vector<double> m_lift;
  std::vector<double> m_depth;
  std::vector<double> m_wall;
  std::vector<double> m_inner_level;
};

Status check(const ShellSettings& settings) {
  if (!(settings.thickness > 0))
    return make_error(ErrorCode::bad_input, "the shell's thickness is {} m; it must be positive", settings.thickness);
  if (settings.layers < 1)
    return make_error(ErrorCode::bad_input, "the shell has {} layers; it needs at least 1", settings.layers);
  if (!(settings.edge > 0))
    return make_error(ErrorCode::bad_input, "the target edge is {} m; it must be positive", settings.edge);
  return {};
}

} // namespace

std::string_view shell_method_name(ShellMethod method) {
  return method == ShellMethod::extruded ? "extruded" : "extruded with locally thinner walls";
}

namespace {

Result<ShellMesh> extrude_once(const SurfaceMesh& surface, const ShellSettings& settings, double refinement) {
  RemeshSettings remesh_settings;
  remesh_settings.edge = settings.edge;
  remesh_settings.finest = settings.finest * refinement;
  remesh_settings.turn *= refinement;
  const Result<SurfaceMesh> outer = remesh(surface, remesh_settings);
  if (!outer)
    return outer.error();
  Extrusion extrusion(surface, *outer, settings);
  if (settings.thin_places == ThinPlaces::refuse)
    if (Status thick = extrusion.check_depths(); !thick)
      return thick.error();
  return extrusion.run();
}

Status accept(const ShellMesh& shell, const ShellSettings& settings) {
  if (shell.self_intersections > 0) {
    const Vec3& x = shell.self_intersection_point;
    return make_error(
        ErrorCode::bad_input,
        "the shell cuts itself in {} pairs of triangles, first at ({:.4g}, {:.4g}, {:.4g}) m. Try a smaller "
        "`resolution` or a thinner wall, or mend the surface if it cuts itself there.",
        shell.self_intersections, x.x(), x.y(), x.z());
  }
  return gate(shell.mesh, shell.quality, settings.limits, shell.reference_volume, "the shell");
}

} // namespace

Result<ShellMesh> extrude_shell(const SurfaceMesh& surface, const ShellSettings& settings) {
  if (Status valid = check(settings); !valid)
    return valid.error();
  // Where the coarsest division does not keep the gate, tight bends are divided more finely.
  Status good;
  Result<ShellMesh> shell = make_error(ErrorCode::bad_input, "nothing was tried");
  for (std::size_t attempt = 0; attempt < REFINEMENTS.size(); ++attempt) {
    shell = extrude_once(surface, settings, REFINEMENTS[attempt]);
    if (!shell)
      return shell;
    shell->refinements = static_cast<int>(attempt);
    good = accept(*shell, settings);
    if (good)
      return shell;
  }
  return good.error();
}

} // namespace wry::geometry
