#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/base/result.h"
#include "sim/geometry/surface_mesh.h"

namespace wry::pipeline {

/// A surface of constant topology that deforms: a collider as animated elsewhere.
struct DeformingSurface {
  geometry::SurfaceMesh mesh;  ///< topology, and the positions of the first sample
  std::vector<Points> samples; ///< positions of all vertices, one sample after the other [m]
  double first_frame = 1.0;    ///< frame number of the first sample
  double frames_per_sample = 1.0;

  /// Positions at a frame, straight between samples; before the first and after the last they stand still.
  Points at(double frame) const;
};

/// What is read at most: 2^31 numbers would be an attack rather than a collider.
inline constexpr std::uint64_t MOST_CACHE_BYTES = std::uint64_t{4} << 30;

/// A PC2 point cache over the mesh whose vertices it moves. Errors: missing_input, io; bad_input for a header that does
/// not fit the file or the mesh, or a number that is none, naming sample and point.
Result<DeformingSurface> read_point_cache(const std::filesystem::path& path, geometry::SurfaceMesh mesh,
                                          double metres_per_unit);

} // namespace wry::pipeline
