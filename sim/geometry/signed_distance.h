#pragma once

#include <cstdint>
#include <memory>

#include "sim/base/result.h"
#include "sim/geometry/surface_mesh.h"

namespace wry::geometry {

/// How finely a signed distance is sampled, and how much of it.
struct SignedDistanceSettings {
  double voxel = 0;                    ///< [m]; the error of a smooth surface is about voxel^2 / (8 radius)
  double exterior_band = 4;            ///< known outside up to this many voxels; a constant beyond
  std::int64_t max_voxels = 200000000; ///< refused above this estimate (about 8 bytes each while it is made)
};

/// Signed distance to a closed surface, sampled by OpenVDB: exact at the voxels, trilinear between, negative inside.
/// All of the inside is sampled. What counts as inside is what cannot be reached from outside, so surfaces that cross
/// themselves or overlap count once. Cheap to copy; queries may run on many threads.
class SignedDistance {
public:
  /// Errors: bad_input for an open or empty surface, a voxel that is not positive, or more voxels than allowed;
  /// out_of_memory; unavailable in a build without OpenVDB.
  static Result<SignedDistance> from_surface(const SurfaceMesh& surface, const SignedDistanceSettings& settings);
  static Result<SignedDistance> from_surface(const SurfaceMesh& surface, double voxel);

  double value(const Vec3& point) const; ///< [m]
  /// Slope of value(), by central differences over a voxel; about a unit vector pointing outward within the band.
  Vec3 gradient(const Vec3& point) const;
  bool is_inside(const Vec3& point) const { return value(point) < 0; }

  double voxel() const; ///< [m]
  std::int64_t sampled_voxels() const;
  std::int64_t bytes() const;
  Vec3 low() const;  ///< least corner of the surface's box [m]
  Vec3 high() const; ///< greatest corner of the surface's box [m]

private:
  struct Grid;
  explicit SignedDistance(std::shared_ptr<const Grid> grid)
      : m_grid(std::move(grid)) {}
  std::shared_ptr<const Grid> m_grid;
};

} // namespace wry::geometry
