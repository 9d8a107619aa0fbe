#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "sim/geometry/prism_split.h"
#include "sim/geometry/tet_mesh.h"
#include "sim/geometry/tet_quality.h"

namespace wry::geometry {

/// A surface extruded inward: every surface vertex is the top of a column of vertices, every triangle of a stack of
/// prisms.
class ShellLayers {
public:
  /// `outer` and `inner` hold a row per vertex; the layers between divide each column evenly.
  ShellLayers(const Triangles& triangles, const Points& outer, const Points& inner, int layers,
              const TetLimits& limits);

  /// Puts a moved vertex back where it belongs, on the outer surface or on the inner one; nothing where it left its
  /// side.
  using Constraint = std::function<std::optional<Vec3>(int column, const Vec3& moved)>;

  /// Chooses the diagonals of the prisms' sides so that the worst tets become better.
  void improve_diagonals();

  /// Slides the ends of columns whose tets have less than `wanted` times the margin of the limits.
  /// Returns the number of columns that still fall short.
  int improve_columns(double wanted, int sweeps, const Constraint& onto_outer, const Constraint& onto_inner);

  /// The least margin of the tets around a column: 1 at the limits, negative where a tet is inverted.
  double column_margin(int column) const;

  TetMesh tet_mesh() const;
  int columns() const { return static_cast<int>(m_outer.rows()); }
  const Points& outer() const { return m_outer; }
  const Points& inner() const { return m_inner; }

private:
  Vec3 point(int column, int layer) const;
  Vec3 point_of(std::int32_t vertex) const {
    return point(vertex % static_cast<int>(m_outer.rows()), vertex / static_cast<int>(m_outer.rows()));
  }
  Diagonal side(Eigen::Index triangle, int layer, int k) const;
  Prism prism(Eigen::Index triangle, int layer) const;
  std::array<std::array<std::int32_t, 4>, 3> tets_of(Eigen::Index triangle, int layer) const;
  double prism_margin(Eigen::Index triangle, int layer) const;
  double tet_margin(const std::array<std::int32_t, 4>& tet) const;
  bool improve_column(int column, double step, const Constraint& onto_outer, const Constraint& onto_inner);
  std::size_t diagonal_index(std::int32_t edge, int layer) const {
    return static_cast<std::size_t>(edge) * static_cast<std::size_t>(m_layers) + static_cast<std::size_t>(layer);
  }

  struct Edge {
    std::int32_t low, high;
    std::array<std::int32_t, 2> triangles;
  };

  Triangles m_triangles;
  Points m_outer;
  Points m_inner;
  int m_layers;
  TetLimits m_limits;
  std::vector<Edge> m_edges;
  Triangles m_edge_of_side;         ///< edge of the side k (corners k, k + 1) of each triangle
  std::vector<char> m_from_low_top; ///< per edge and layer: from the low column's top to the high column's bottom
  std::vector<std::vector<std::int32_t>> m_triangles_of_column;
};

} // namespace wry::geometry
