#pragma once

#include <cstdint>
#include <vector>

#include "sim/base/result.h"
#include "sim/geometry/surface_mesh.h"

namespace wry::geometry {

/// A closed manifold triangle mesh that can be edited: half-edge 3 t + k runs along triangle t from its corner k to
/// corner k + 1. Used by the remesher; vertices and triangles that an edit removes stay as holes until `compact()`.
class HalfEdgeMesh {
public:
  /// Errors: bad_input naming the first edge that does not have exactly two triangles with opposite directions, or a
  /// vertex whose triangles are not one fan.
  static Result<HalfEdgeMesh> from_surface(const SurfaceMesh& surface);

  int half_edges() const { return static_cast<int>(m_twin.size()); }
  int vertices() const { return static_cast<int>(m_points.size()); }
  bool is_alive(int half_edge) const { return m_origin[at(half_edge)] >= 0; }
  bool is_vertex_alive(int vertex) const { return m_out[at(vertex)] >= 0; }

  static int next(int h) { return h - h % 3 + (h + 1) % 3; }
  static int previous(int h) { return h - h % 3 + (h + 2) % 3; }
  int twin(int h) const { return m_twin[at(h)]; }
  int from(int h) const { return m_origin[at(h)]; }
  int to(int h) const { return m_origin[at(next(h))]; }
  int apex(int h) const { return m_origin[at(previous(h))]; }
  /// A half-edge that leaves the vertex.
  int out(int vertex) const { return m_out[at(vertex)]; }
  /// The next half-edge that leaves the same vertex.
  int around(int h) const { return m_twin[at(previous(h))]; }
  int valence(int vertex) const;

  Vec3& point(int vertex) { return m_points[at(vertex)]; }
  const Vec3& point(int vertex) const { return m_points[at(vertex)]; }
  double length(int h) const { return (point(from(h)) - point(to(h))).norm(); }
  Vec3 normal(int triangle) const; ///< not normalised

  bool is_feature(int h) const { return m_feature[at(h)] != 0; }
  void mark_feature(int h) { m_feature[at(h)] = m_feature[at(twin(h))] = 1; }

  /// Puts a vertex on an edge; returns it.
  int split(int h, const Vec3& point);
  /// Turns the edge within its two triangles; false if the new edge is there already.
  bool flip(int h);
  /// Whether removing from(h) by drawing it into to(h) keeps the mesh manifold.
  bool can_collapse(int h) const;
  void collapse(int h);

  SurfaceMesh to_surface() const;

private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  void connect(int a, int b) {
    m_twin[at(a)] = b;
    m_twin[at(b)] = a;
  }
  int add_triangle(int a, int b, int c);

  std::vector<Vec3> m_points;
  std::vector<int> m_out;
  std::vector<int> m_origin; ///< -1 where the triangle was removed
  std::vector<int> m_twin;
  std::vector<char> m_feature;
};

} // namespace wry::geometry
