#include "sim/geometry/signed_distance.h"

namespace wry::geometry {

Result<SignedDistance> SignedDistance::from_surface(const SurfaceMesh& surface, double voxel) {
  SignedDistanceSettings settings;
  settings.voxel = voxel;
  return from_surface(surface, settings);
}

} // namespace wry::geometry
