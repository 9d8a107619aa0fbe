#pragma once

#include <span>
#include <vector>

#include "sim/base/parallel.h"
#include "sim/base/result.h"
#include "sim/mpm/grid.h"
#include "sim/mpm/particles.h"

namespace wry::mpm {

/// The particles of one set in one block: whole tiles, the last one filled up with copies of the last particle.
struct BlockRun {
  BlockCoord coord;
  std::int32_t block = 0; ///< among the occupied blocks of the grid
  std::int32_t count = 0; ///< of particles
  std::int64_t first_tile = 0;
};

/// A set and where its particles are.
template <class Scalar> struct SortedSet {
  ParticleSet<Scalar> particles;
  std::vector<BlockRun> runs; ///< ascending by coord

  std::size_t count() const;
};

/// A particle that is to be added: its block is any that leaves a small position in it.
struct NewParticle {
  BlockCoord block;
  Vec3 position = Vec3::Zero(); ///< in cells from the block's first node
};

/// The block and the position in it, in cells of `cell` [m], of a point of the world. Errors: solver for a point that
/// is not finite or further than 2^60 cells away.
Result<NewParticle> place_in_grid(const Vec3& point, double cell);

/// Puts every particle into the block it is in now, blocks ascending, cells of a block ascending, particles of a cell
/// in the order they had: a stable counting sort. Positions become relative to the new blocks. `added` are new
/// particles, behind the others in every cell, with initial values in all channels but position and identity
/// (first_identity onwards). Errors: solver naming a particle that is nowhere.
template <class Scalar>
Status sort_particles(SortedSet<Scalar>& set, std::span<const NewParticle> added, std::int64_t first_identity,
                      const Threads& threads);

/// The blocks of all runs, ascending, none twice; every run learns its place among them.
template <class Scalar> std::vector<BlockCoord> occupied_blocks(std::span<SortedSet<Scalar>> sets);

/// Identities are stored as the bits of an integer of the scalar's size.
std::int64_t identity_of(float bits);
std::int64_t identity_of(double bits);
template <class Scalar> Scalar identity_bits(std::int64_t identity);

} // namespace wry::mpm
