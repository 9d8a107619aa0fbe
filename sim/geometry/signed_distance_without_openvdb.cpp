#include "sim/geometry/signed_distance.h"

namespace wry::geometry {

struct SignedDistance::Grid {};

Result<SignedDistance> SignedDistance::from_surface(const SurfaceMesh&, const SignedDistanceSettings&) {
  return make_error(ErrorCode::unavailable,
                    "solids from surface meshes need signed distances: this build has no OpenVDB; configure with "
                    "-DWRY_WITH_OPENVDB=ON");
}

// No object can exist without from_surface(), so these are never called.
double SignedDistance::value(const Vec3&) const {
  return 0;
}
Vec3 SignedDistance::gradient(const Vec3&) const {
  return Vec3::Zero();
}
double SignedDistance::voxel() const {
  return 0;
}
std::int64_t SignedDistance::sampled_voxels() const {
  return 0;
}
std::int64_t SignedDistance::bytes() const {
  return 0;
}
Vec3 SignedDistance::low() const {
  return Vec3::Zero();
}
Vec3 SignedDistance::high() const {
  return Vec3::Zero();
}

} // namespace wry::geometry
