#include "sim/geometry/shell_extrusion_layers.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace wry::geometry {

ShellLayers::ShellLayers(const Triangles& triangles, const Points& outer, const Points& inner, int layers,
                         const TetLimits& limits)
    : m_triangles(triangles)
    , m_outer(outer)
    , m_inner(inner)
    , m_layers(layers)
    , m_limits(limits)
    , m_edge_of_side(triangles.rows(), 3)
    , m_triangles_of_column(static_cast<std::size_t>(outer.rows())) {
  struct Side {
    std::int32_t low, high, triangle, k;
  };
  std::vector<Side> sides;
  for (std::int32_t t = 0; t < triangles.rows(); ++t) {
    for (std::int32_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax({triangles(t, k), triangles(t, (k + 1) % 3)});
      sides.push_back({low, high, t, k});
      m_triangles_of_column[static_cast<std::size_t>(triangles(t, k))].push_back(t);
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::array{a.low, a.high, a.triangle} < std::array{b.low, b.high, b.triangle};
  });
  for (const Side& side : sides) {
    if (m_edges.empty() || m_edges.back().low != side.low || m_edges.back().high != side.high)
      m_edges.push_back({side.low, side.high, {side.triangle, side.triangle}});
    m_edges.back().triangles[1] = side.triangle;
    m_edge_of_side(side.triangle, side.k) = static_cast<std::int32_t>(m_edges.size() - 1);
  }
  // Starting from the columns' order every prism is splittable; alternating layers favours no direction.
  m_from_low_top.resize(m_edges.size() * static_cast<std::size_t>(m_layers));
  for (std::size_t i = 0; i < m_from_low_top.size(); ++i)
    m_from_low_top[i] = static_cast<int>(i) % m_layers % 2 == 0 ? 1 : 0;
}

Vec3 ShellLayers::point(int column, int layer) const {
  const double share = static_cast<double>(layer) / m_layers;
  return ((1 - share) * m_outer.row(column) + share * m_inner.row(column)).transpose();
}

Diagonal ShellLayers::side(Eigen::Index triangle, int layer, int k) const {
  const std::int32_t edge = m_edge_of_side(triangle, k);
  const bool starts_low = m_triangles(triangle, k) == m_edges[static_cast<std::size_t>(edge)].low;
  return (m_from_low_top[diagonal_index(edge, layer)] != 0) == starts_low ? Diagonal::down : Diagonal::up;
}

Prism ShellLayers::prism(Eigen::Index triangle, int layer) const {
  const auto count = static_cast<std::int32_t>(m_outer.rows());
  Prism prism{};
  for (int k = 0; k < 3; ++k) {
    prism.top[k] = layer * count + m_triangles(triangle, k);
    prism.bottom[k] = prism.top[k] + count;
  }
  return prism;
}

std::array<std::array<std::int32_t, 4>, 3> ShellLayers::tets_of(Eigen::Index triangle, int layer) const {
  return split_prism(prism(triangle, layer),
                     {side(triangle, layer, 0), side(triangle, layer, 1), side(triangle, layer, 2)});
}

double ShellLayers::tet_margin(const std::array<std::int32_t, 4>& tet) const {
  const std::array<Vec3, 4> x{point_of(tet[0]), point_of(tet[1]), point_of(tet[2]), point_of(tet[3])};
  // Outward normals of the faces; the angle between faces i and j is that of n_i and -n_j.
  std::array<Vec3, 4> normals{(x[2] - x[1]).cross(x[3] - x[1]), (x[3] - x[0]).cross(x[2] - x[0]),
                              (x[1] - x[0]).cross(x[3] - x[0]), (x[2] - x[0]).cross(x[1] - x[0])};
  const double six_volumes = (x[1] - x[0]).cross(x[2] - x[0]).dot(x[3] - x[0]);
  if (!(six_volumes > 0)) {
    const double size = (x[1] - x[0]).norm();
    return six_volumes / (size * size * size) - 1e-6;
  }
  for (Vec3& normal : normals)
    normal.normalize();
  double least = 1;
  double greatest = -1;
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      const double cosine = -normals[i].dot(normals[j]);
      least = std::min(least, cosine);
      greatest = std::max(greatest, cosine);
    }
  }
  const double sharpest = std::acos(std::min(greatest, 1.0)) * 180 / M_PI;
  const double flattest = std::acos(std::max(least, -1.0)) * 180 / M_PI;
  return std::min(sharpest / m_limits.min_dihedral, (180 - flattest) / (180 - m_limits.max_dihedral));
}

double ShellLayers::prism_margin(Eigen::Index triangle, int layer) const {
  double margin = 1e9;
  for (const auto& tet : tets_of(triangle, layer))
    margin = std::min(margin, tet_margin(tet));
  return margin;
}

double ShellLayers::column_margin(int column) const {
  double margin = 1e9;
  for (const std::int32_t triangle : m_triangles_of_column[static_cast<std::size_t>(column)])
    for (int layer = 0; layer < m_layers; ++layer)
      margin = std::min(margin, prism_margin(triangle, layer));
  return margin;
}

void ShellLayers::improve_diagonals() {
  bool changed = true;
  for (int sweep = 0; changed && sweep < 8; ++sweep) {
    changed = false;
    for (std::size_t edge = 0; edge < m_edges.size(); ++edge) {
      const auto [a, b] = m_edges[edge].triangles;
      for (int layer = 0; layer < m_layers; ++layer) {
        char& diagonal = m_from_low_top[diagonal_index(static_cast<std::int32_t>(edge), layer)];
        const double before = std::min(prism_margin(a, layer), prism_margin(b, layer));
        diagonal = diagonal ? 0 : 1;
        const auto splittable = [&](std::int32_t t) {
          return is_splittable({side(t, layer, 0), side(t, layer, 1), side(t, layer, 2)});
        };
        const bool better =
            splittable(a) && splittable(b) && std::min(prism_margin(a, layer), prism_margin(b, layer)) > before + 1e-9;
        if (!better)
          diagonal = diagonal ? 0 : 1;
        changed = changed || better;
      }
    }
  }
}

bool ShellLayers::improve_column(int column, double step, const Constraint& onto_outer, const Constraint& onto_inner) {
  double best = column_margin(column);
  const Vec3 axis = (m_outer.row(column) - m_inner.row(column)).transpose().normalized();
  const Vec3 u = axis.unitOrthogonal();
  const Vec3 v = axis.cross(u);
  bool improved = false;
  for (int direction = 0; direction < 8; ++direction) {
    const double angle = direction * M_PI / 4;
    const Vec3 offset = step * (std::cos(angle) * u + std::sin(angle) * v);
    for (int which = 0; which < 3; ++which) { // inner end, outer end, both
      const Vec3 old_outer = m_outer.row(column).transpose();
      const Vec3 old_inner = m_inner.row(column).transpose();
      const std::optional<Vec3> inner = which != 1 ? onto_inner(column, old_inner + offset) : old_inner;
      const std::optional<Vec3> outer = which != 0 ? onto_outer(column, old_outer + offset) : old_outer;
      if (!inner || !outer)
        continue;
      m_inner.row(column) = inner->transpose();
      m_outer.row(column) = outer->transpose();
      const double margin = column_margin(column);
      if (margin > best + 1e-6) {
        best = margin;
        improved = true;
      } else {
        m_outer.row(column) = old_outer.transpose();
        m_inner.row(column) = old_inner.transpose();
      }
    }
  }
  return improved;
}

int ShellLayers::improve_columns(double wanted, int sweeps, const Constraint& onto_outer,
                                 const Constraint& onto_inner) {
  int short_of = 0;
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    short_of = 0;
    bool improved = false;
    for (int column = 0; column < columns(); ++column) {
      if (column_margin(column) >= wanted)
        continue;
      ++short_of;
      const double size = (m_outer.row(column) - m_inner.row(column)).norm();
      for (const double share : {0.4, 0.1, 0.03})
        improved = improve_column(column, share * size, onto_outer, onto_inner) || improved;
    }
    if (!improved)
      break;
    improve_diagonals();
  }
  return short_of;
}

TetMesh ShellLayers::tet_mesh() const {
  TetMesh mesh;
  const Eigen::Index count = m_outer.rows();
  mesh.vertices.resize(count * (m_layers + 1), 3);
  for (int layer = 0; layer <= m_layers; ++layer)
    for (int column = 0; column < count; ++column)
      mesh.vertices.row(layer * count + column) = point(column, layer).transpose();
  mesh.tets.resize(m_triangles.rows() * m_layers * 3, 4);
  Eigen::Index row = 0;
  for (Eigen::Index triangle = 0; triangle < m_triangles.rows(); ++triangle)
    for (int layer = 0; layer < m_layers; ++layer)
      for (const auto& tet : tets_of(triangle, layer))
        mesh.tets.row(row++) << tet[0], tet[1], tet[2], tet[3];
  return mesh;
}

} // namespace wry::geometry
