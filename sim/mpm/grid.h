#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "sim/base/aligned.h"
#include "sim/base/types.h"
#include "sim/mpm/kernels/transfer.h"

namespace wry::mpm {

/// Which block of 4^3 nodes: its first node is at 4 times this, in cells from the world's origin. 64 bits, so that a
/// particle at 1e9 m is a particle like others.
struct BlockCoord {
  std::int64_t x = 0, y = 0, z = 0;
  auto operator<=>(const BlockCoord&) const = default; // NOLINT(modernize-use-nullptr)
};

struct BlockCoordHash {
  std::size_t operator()(const BlockCoord& coord) const;
};

/// Where blocks are found by their coordinates.
using BlockIndex = std::unordered_map<BlockCoord, std::int32_t, BlockCoordHash>;

/// A sparse grid: blocks that have particles, and their neighbours.
template <class Scalar> class Grid {
public:
  /// Blocks for these blocks of particles (ascending, none twice) and everything around them.
  void build(std::span<const BlockCoord> occupied);

  std::size_t block_count() const { return m_coords.size(); }
  std::size_t occupied_count() const { return m_neighbours.size(); }
  const BlockCoord& coord(std::size_t block) const { return m_coords[block]; }
  Scalar* values(std::size_t block) { return m_values.data() + block * BLOCK_VALUES; }
  const Scalar* values(std::size_t block) const { return m_values.data() + block * BLOCK_VALUES; }
  /// The blocks around an occupied one and itself, z fastest.
  const std::array<std::int32_t, NEIGHBOURS>& neighbours(std::size_t occupied) const { return m_neighbours[occupied]; }
  std::size_t memory_bytes() const;

private:
  std::vector<BlockCoord> m_coords;
  std::vector<std::array<std::int32_t, NEIGHBOURS>> m_neighbours; ///< per occupied block
  AlignedVector<Scalar> m_values;
};

extern template class Grid<float>;
extern template class Grid<double>;

} // namespace wry::mpm
