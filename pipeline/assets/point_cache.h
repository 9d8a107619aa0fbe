#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "sim/base/result.h"
#include "sim/base/types.h"

namespace wry::pipeline {

/// What a PC2 file holds: the points of one object over time.
struct PointCache {
  std::vector<Points> samples; ///< positions of all points in units of the file, one sample after the other
  double first_frame = 1.0;    ///< frame number of the first sample
  double frames_per_sample = 1.0;
};

/// What is read at most: 2^31 numbers would be an attack rather than a collider.
inline constexpr std::uint64_t MOST_CACHE_BYTES = std::uint64_t{4} << 30;

/// A PC2 point cache of a mesh of so many vertices. Errors: missing_input, io; bad_input for a header that does not fit
/// the file or the mesh, or a number that is none, naming sample and point.
Result<PointCache> read_point_cache(const std::filesystem::path& path, Eigen::Index vertices);

} // namespace wry::pipeline
