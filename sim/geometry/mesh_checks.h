#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/parallel.h"
#include "sim/base/result.h"
#include "sim/geometry/surface_mesh.h"

namespace wry::geometry {

/// How often something is wrong, and the first few places.
struct MeshFlaw {
  std::int64_t count = 0;
  std::vector<std::int32_t> examples; ///< the lowest indices, at most 8
};

/// A hole: edges that belong to one triangle only, end to end.
struct BoundaryLoop {
  std::int64_t edges = 0;
  double length = 0;          ///< [m]
  Vec3 centre = Vec3::Zero(); ///< of its bounding box [m]
  Vec3 extent = Vec3::Zero(); ///< of its bounding box [m]
  std::int32_t first_vertex = -1;
};

/// What can be said about a surface without changing it. Triangles with bad indices or repeated corners are left out of
/// all that follows them here.
struct MeshReport {
  std::int64_t vertices = 0;
  std::int64_t triangles = 0;
  MeshFlaw non_finite_vertices;
  MeshFlaw bad_indices;          ///< triangles that name a vertex that is not there
  MeshFlaw repeated_corners;     ///< triangles that name a vertex twice
  MeshFlaw zero_area_triangles;  ///< height below 1e-12 of the longest edge
  MeshFlaw duplicate_triangles;  ///< the same three vertices as an earlier triangle, in any order
  MeshFlaw nonmanifold_edges;    ///< edges of more than two triangles; examples are their first vertices
  MeshFlaw nonmanifold_vertices; ///< vertices where separate fans of triangles meet
  MeshFlaw inconsistent_edges;   ///< edges that both triangles run the same way; examples are their first vertices
  std::int64_t boundary_edges = 0;
  std::int64_t boundary_loops = 0;
  std::vector<BoundaryLoop> longest_loops; ///< at most 8, longest first
  std::int64_t components = 0;             ///< parts joined by edges
  std::int64_t unused_vertices = 0;
  double area = 0;           ///< [m^2]
  double volume = 0;         ///< signed [m^3]; of meaning when closed and oriented
  Vec3 lower = Vec3::Zero(); ///< of the bounding box of used, finite vertices [m]
  Vec3 upper = Vec3::Zero(); ///< [m]

  bool is_valid() const {
    return triangles > 0 && non_finite_vertices.count == 0 && bad_indices.count == 0 && repeated_corners.count == 0;
  }
  bool is_closed() const { return boundary_edges == 0 && triangles > 0; }
  bool is_manifold() const { return nonmanifold_edges.count == 0 && nonmanifold_vertices.count == 0; }
  bool is_oriented() const { return inconsistent_edges.count == 0; }
  Vec3 extent() const { return upper - lower; }
};

/// Looks at a mesh; never fails, whatever the mesh.
MeshReport inspect_mesh(const SurfaceMesh& mesh);

/// bad_input unless there are triangles, all finite and with indices in range. `name` is what the message calls the
/// mesh.
Status check_valid(const SurfaceMesh& mesh, const MeshReport& report, const std::string& name);

/// bad_input naming the longest hole, its length and its place, unless the mesh is closed.
Status check_closed(const MeshReport& report, const std::string& name);

/// bad_input naming the first place, unless edges and vertices are manifold.
Status check_manifold(const SurfaceMesh& mesh, const MeshReport& report, const std::string& name);

/// What orient_outward did.
struct OrientReport {
  std::int64_t flipped = 0;    ///< triangles
  std::int64_t cavities = 0;   ///< closed parts inside others that bound a hollow
  bool nesting_checked = true; ///< false: too many nested parts to tell hollows; every closed part was turned outward
};

/// Makes neighbouring triangles agree, then turns closed parts outward. A part that lies inside another keeps its sense
/// relative to it when its triangles agreed from the start: so a hollow stays hollow, also in a mesh that is inside
/// out. Open parts keep the sense of most of their triangles. Errors: bad_input for a surface that has no two sides
/// (Moebius), or whose indices are out of range.
Result<OrientReport> orient_outward(SurfaceMesh& mesh);

/// Pairs of triangles that cut or touch each other without sharing the vertices there.
struct SelfIntersections {
  bool complete = true;                                     ///< false: stopped at the limit
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs; ///< ascending
};

/// Exact (adaptive floating-point predicates): touching counts. Triangles without area or with bad indices are skipped.
/// Stops at about `limit` pairs. Same answer on any number of threads.
SelfIntersections find_self_intersections(const SurfaceMesh& mesh, const Threads& threads, std::size_t limit = 1000);

/// bad_input naming the first pair and its place, if there is one.
Status check_no_self_intersections(const SurfaceMesh& mesh, const SelfIntersections& found, const std::string& name);

} // namespace wry::geometry
