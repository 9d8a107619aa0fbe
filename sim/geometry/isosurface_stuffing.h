#pragma once

#include <functional>

#include "sim/base/result.h"
#include "sim/geometry/tet_mesh.h"
#include "sim/geometry/tet_quality.h"

namespace wry::geometry {

/// A function of space, negative inside a body, near its surface about the signed distance [m].
using DistanceFunction = std::function<double(const Vec3&)>;

/// A box along the axes [m].
struct Bounds {
  Vec3 low = Vec3::Zero();
  Vec3 high = Vec3::Zero();
};

/// How a solid is filled with tets.
struct StuffingSettings {
  double edge = 0;                     ///< length of the lattice's long edges [m]; the short ones are 0.87 of it
  TetLimits limits{10.0, 165.0, .02};  ///< what the result must keep
  std::int64_t max_lattice = 60000000; ///< lattice points that may be held (about 16 bytes each)
};

/// A solid filled with tets, and how well.
struct SolidMesh {
  TetMesh mesh;
  TetQuality quality;
  double reference_volume = 0;   ///< of the surface [m^3]
  double level_shift = 0;        ///< the isosurface used, so that a coarse lattice keeps the volume [m]
  std::int64_t removed_tets = 0; ///< crumbs and pinched places that were taken away
};

/// Fills {distance < level} with tets of a body-centred cubic lattice whose surface points are moved or cut to the
/// isosurface (Labelle and Shewchuk 2007): dihedral angles stay within 10.7 and 164.8 degrees whatever the shape.
/// Features thinner than the lattice may be lost. `bounds` must hold the body. Errors: bad_input if the edge is not
/// positive or the lattice would be larger than allowed.
Result<TetMesh> stuff_isosurface(const DistanceFunction& distance, const Bounds& bounds, double level,
                                 const StuffingSettings& settings);

/// Fills a closed surface. The isosurface is shifted until the volume agrees with the surface's to .2 %. Errors:
/// bad_input for an open surface, a shape thinner than the lattice, or a mesh beyond the limits; unavailable without
/// OpenVDB.
Result<SolidMesh> stuff_solid(const SurfaceMesh& surface, const StuffingSettings& settings);

/// Takes away the smaller side of every non-manifold edge and vertex, and pieces below a thousandth of the volume;
/// drops unused vertices. Returns the number of tets taken.
std::int64_t remove_pinches_and_crumbs(TetMesh& mesh);

} // namespace wry::geometry
