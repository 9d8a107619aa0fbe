#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "sim/geometry/isosurface_stuffing.h"
#include "sim/geometry/signed_distance.h"
#include "sim/geometry/signed_distance_volume.h"

namespace wry::geometry {

namespace {

/// Voxels per lattice edge: trilinear values are then good to a few thousandths of the edge.
constexpr double VOXELS_PER_EDGE = 3;
/// Relative volume error that ends the search for the isosurface, its steps, and how far it may shift, in edges.
constexpr double VOLUME_TOLERANCE = .002;
constexpr int VOLUME_STEPS = 4;
constexpr double MAX_SHIFT = 0.25;

double total_volume(const TetMesh& mesh) {
  double volume = 0;
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t)
    volume += tet_volume(mesh, t);
  return volume;
}

double area_of(const SurfaceMesh& surface) {
  double area = 0;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    const Vec3 a = surface.vertices.row(surface.triangles(t, 0)).transpose();
    const Vec3 b = surface.vertices.row(surface.triangles(t, 1)).transpose();
    const Vec3 c = surface.vertices.row(surface.triangles(t, 2)).transpose();
    area += (b - a).cross(c - a).norm() / 2;
  }
  return area;
}

} // namespace

Result<SolidMesh> stuff_solid(const SurfaceMesh& surface, const StuffingSettings& settings) {
  if (!(settings.edge > 0))
    return make_error(ErrorCode::bad_input, "the target edge is {} m; it must be positive", settings.edge);
  const Result<SignedDistance> distance = SignedDistance::from_surface(surface, settings.edge / VOXELS_PER_EDGE);
  if (!distance)
    return distance.error();
  const DistanceFunction value = [&](const Vec3& x) { return distance->value(x); };
  const Bounds bounds{distance->low(), distance->high()};
  SolidMesh solid;
  solid.reference_volume = volume_between(value, bounds, -1e9, 0.0, distance->voxel());
  const double area = area_of(surface);
  for (int step = 0; step < VOLUME_STEPS; ++step) {
    Result<TetMesh> mesh = stuff_isosurface(value, bounds, solid.level_shift, settings);
    if (!mesh)
      return mesh.error();
    solid.mesh = *std::move(mesh);
    solid.removed_tets = remove_pinches_and_crumbs(solid.mesh);
    const double missing = solid.reference_volume - total_volume(solid.mesh);
    if (std::abs(missing) < VOLUME_TOLERANCE * solid.reference_volume || step + 1 == VOLUME_STEPS)
      break;
    solid.level_shift =
        std::clamp(solid.level_shift + missing / area, -MAX_SHIFT * settings.edge, MAX_SHIFT * settings.edge);
  }
  solid.quality = measure(solid.mesh);
  if (Status good = gate(solid.mesh, solid.quality, settings.limits, solid.reference_volume, "the solid"); !good)
    return good.error();
  return solid;
}

} // namespace wry::geometry
