#pragma once

#include <array>
#include <vector>

#include "sim/base/parallel.h"
#include "sim/geometry/surface_mesh.h"
#include "sim/geometry/tet_mesh.h"

namespace wry::geometry {

/// A fine surface carried along by the coarse tets that were made from it, so that an artist's own mesh can be drawn.
///
/// Points follow Phong deformation (James 2020): besides the linear map of their tet, the deformation gradients
/// averaged at its corners bend the surface smoothly, so that no facets of the tets show. Exact for affine
/// deformations.
class SurfaceEmbedding {
public:
  /// Ties every point (a row each) to the tet that holds it, or to the nearest; points may lie a little outside.
  static SurfaceEmbedding make(const TetMesh& mesh, const Points& points);

  /// Where the points are when the tets' vertices are at `positions` (rows as in the tet mesh). The same bits on any
  /// number of threads.
  Points deform(const Points& positions, const Threads& threads) const;

  /// Values per vertex of the tet mesh (vertices x components, row after row), between the corners of each point's tet.
  std::vector<double> interpolate(const std::vector<double>& values, int components) const;

  /// The point that lies farthest outside the tets at rest.
  struct Farthest {
    double distance = 0.0; ///< from its tet [m]; 0: all are inside
    double edge = 0.0;     ///< longest edge of that tet [m]
    Vec3 point = Vec3::Zero();
  };
  Farthest farthest() const;

  Eigen::Index points() const { return m_rest_points.rows(); }
  /// The tet of a point, and its barycentric weights there; one is negative where the point lies outside.
  std::int32_t tet(Eigen::Index point) const { return m_tet[static_cast<std::size_t>(point)]; }
  const Vec4& weights(Eigen::Index point) const { return m_weights[static_cast<std::size_t>(point)]; }

private:
  std::vector<Mat3> corner_gradients(const Points& positions, const Threads& threads) const;

  Points m_rest_points;
  Points m_rest_vertices;
  Tets m_tets;
  std::vector<Mat3> m_inverse_edges;         ///< per tet: inverse of (x1-x0, x2-x0, x3-x0) at rest
  std::vector<double> m_volumes;             ///< of the tets at rest [m^3]
  std::vector<std::int32_t> m_tets_of_begin; ///< per vertex: where its tets begin in m_tets_of
  std::vector<std::int32_t> m_tets_of;
  std::vector<std::int32_t> m_tet;
  std::vector<Vec4> m_weights;
};

} // namespace wry::geometry
