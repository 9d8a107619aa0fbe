#pragma once

#include <cstdint>
#include <functional>

#include "sim/base/result.h"
#include "sim/base/types.h"

namespace wry::mpm {

/// How particles stand at the start.
enum class Sampling {
  lattice,  ///< regular
  jittered, ///< each somewhere in its cell of the lattice: no rows to be seen
};

struct SeedSettings {
  double cell = 0.0; ///< of the grid [m]
  double particles_per_cell = 8.0;
  Sampling sampling = Sampling::lattice;
  std::uint64_t seed = 1; ///< of the jitter
  std::size_t most = 0;   ///< more particles than this are refused; 0: no limit
};

struct Seeds {
  Points positions;    ///< [m]
  double volume = 0.0; ///< of each [m^3]
};

/// How many lattice points fill a box; of a body in it no more become particles.
double lattice_size(const Vec3& low, const Vec3& high, const SeedSettings& settings);

/// Fills what is `inside` of a box with particles on a lattice that fits the box. Errors: bad_input when there is none
/// (with what to do), out_of_memory when there are more than settings.most.
Result<Seeds> fill(const Vec3& low, const Vec3& high, const std::function<bool(const Vec3&)>& inside,
                   const SeedSettings& settings);

} // namespace wry::mpm
