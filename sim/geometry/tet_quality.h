#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "sim/base/result.h"
#include "sim/geometry/tet_mesh.h"

namespace wry::geometry {

/// Figures of a tet mesh that decide whether it can be simulated; `wry plan` prints them.
struct TetQuality {
  std::int64_t tets = 0;
  std::int64_t vertices = 0;
  double volume = 0;           ///< [m^3]
  double min_volume = 0;       ///< of a tet, signed [m^3]
  double min_dihedral = 0;     ///< [degrees]
  double max_dihedral = 0;     ///< [degrees]
  double min_edge = 0;         ///< [m]
  double mean_edge = 0;        ///< [m]
  double max_edge = 0;         ///< [m]
  std::int32_t worst_tet = -1; ///< that of least dihedral angle, or of least volume if one is not positive
  std::int64_t non_positive_tets = 0;
  std::int64_t unused_vertices = 0;
  std::int64_t non_manifold_edges = 0;               ///< boundary edges with other than two boundary triangles
  std::int64_t non_manifold_vertices = 0;            ///< boundary vertices whose boundary triangles are not one fan
  std::int64_t overused_faces = 0;                   ///< faces of more than two tets
  std::int64_t components = 0;                       ///< pieces connected through faces
  std::array<std::int64_t, 18> dihedral_histogram{}; ///< counts in bins of 10 degrees
};

/// What a mesh must keep to be passed on.
struct TetLimits {
  double min_dihedral = 10;  ///< [degrees]; 5 for extruded shells
  double max_dihedral = 165; ///< [degrees]
  double volume_error = .02; ///< relative to the surface it was made from
};

/// Counts and angles of a mesh; works on any indices in range, also on inverted or tangled meshes.
TetQuality measure(const TetMesh& mesh);

/// Relative volume error |volume - reference| / reference.
double volume_error(const TetQuality& quality, double reference_volume);

/// Whether the figures are within the limits. Errors: bad_input naming the figure, the limit and the worst place.
/// `what` names the body in the message; `reference_volume` [m^3] of 0 means that there is none to compare with.
Status gate(const TetMesh& mesh, const TetQuality& quality, const TetLimits& limits, double reference_volume,
            const std::string& what);

/// "12,345 tets, 3,210 vertices, dihedral angles 11.2 to 152.3 degrees, ..." in one line.
std::string describe(const TetQuality& quality);

/// Signed volume of one tet [m^3].
double tet_volume(const TetMesh& mesh, Eigen::Index tet);

/// Six dihedral angles [degrees] of a tet given by its corners, edges 01 02 03 12 13 23.
std::array<double, 6> dihedral_angles(const std::array<Vec3, 4>& corners);

/// Volume enclosed by triangles [m^3]; meaningful for closed ones.
double enclosed_volume(const Points& vertices, const Triangles& triangles);

} // namespace wry::geometry
