#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/geometry/surface_mesh.h"

namespace wry::geometry {

/// The point of a surface nearest to a query.
struct ClosestPoint {
  Vec3 point = Vec3::Zero();       ///< [m]
  std::int32_t triangle = -1;      ///< -1 when the tree is empty
  Vec3 barycentric = Vec3::Zero(); ///< weights of the triangle's corners
  double distance = 0;             ///< [m], unsigned
};

/// Exact closest points and signed distances to triangles, through a bounding-volume tree.
///
/// The sign is that of the angle-weighted pseudonormal (Baerentzen and Aanaes 2005): exact for a closed, oriented mesh
/// that does not cross itself. Ties go to the triangle of least index, so answers do not depend on the tree's layout.
class ClosestPointTree {
public:
  explicit ClosestPointTree(const SurfaceMesh& mesh);

  ClosestPoint closest(const Vec3& point) const;
  /// The same when it is at most `reach` [m] away; else triangle is -1. Much cheaper where nothing is near.
  ClosestPoint closest_within(const Vec3& point, double reach) const;

  /// Triangles of which one is the nearest, whatever point within `radius` [m] of the centre is asked for. Their
  /// numbers are this tree's own, for closest_of().
  std::vector<std::int32_t> nearest_around(const Vec3& centre, double radius) const;
  /// closest() where it is known to be on one of these, to the same bits.
  ClosestPoint closest_of(const Vec3& point, std::span<const std::int32_t> leaves) const;

  /// Distance [m], negative inside.
  double signed_distance(const Vec3& point) const;

  /// Unit pseudonormal of the surface at a closest point: of the face, edge or corner it lies on.
  Vec3 pseudonormal(const ClosestPoint& closest) const;

  /// Angle-weighted unit normals, a row per vertex; zero where a vertex has no area around it.
  const Points& vertex_normals() const { return m_vertex_normals; }
  /// Unit normal of the vertices, interpolated at a closest point.
  Vec3 smooth_normal(const ClosestPoint& closest) const;
  const SurfaceMesh& mesh() const { return m_mesh; }

private:
  struct Node {
    Vec3 low, high;
    std::int32_t left = -1; ///< first child; the second follows it. -1 at a leaf
    std::int32_t begin = 0, end = 0;
  };
  /// A triangle of a leaf, with what tells cheaply that it is too far away.
  struct Leaf {
    Vec3 corner[3];
    Vec3 low, high;
    Vec3 normal; ///< unit; zero where it has no area
  };
  /// The best so far, by its squared distance.
  struct Nearest {
    ClosestPoint closest;
    double squared;
  };
  void look_at(std::int32_t leaf, const Vec3& point, Nearest& best) const;
  /// Calls look(leaf) for those of nodes no further from a point than `squared`, which look() may make less.
  template <class Look> void for_leaves_within(const Vec3& point, const double& squared, const Look& look) const;
  void build(std::size_t node, int depth);
  void make_leaves();
  void make_normals();

  SurfaceMesh m_mesh;
  std::vector<Node> m_nodes;
  std::vector<std::int32_t> m_order;
  std::vector<Leaf> m_leaves; ///< in that order
  Points m_centroids;
  Points m_face_normals;
  Points m_vertex_normals;
  Points m_edge_normals; ///< 3 rows per triangle: edges (0,1), (1,2), (2,0)
};

} // namespace wry::geometry
