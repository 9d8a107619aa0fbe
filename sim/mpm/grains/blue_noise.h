#pragma once

#include <cstdint>

#include "sim/base/types.h"

namespace wry::mpm {

/// `per_particle` points in the cube of every particle (its volume, axes of the world), spread as blue noise over all
/// of them: of a few candidates each takes the one that is furthest from the points so far. Rows in the order of the
/// particles, `per_particle` rows each. Deterministic in `seed`.
Points spread_in_particles(const Points& particles, double particle_volume, int per_particle, std::uint64_t seed);

} // namespace wry::mpm
