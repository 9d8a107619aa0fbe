#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "sim/mpm/particle_sort.h"

namespace wry::mpm {

/// Which runs of particles lie in which occupied block of the grid, and which blocks can be scattered at the same time.
class ParticleBlocks {
public:
  static constexpr int COLOURS = 8;
  using Run = std::pair<std::size_t, std::size_t>; ///< body, run of its set

  /// `occupied` in the grid's order.
  template <class Scalar>
  void build(const std::vector<SortedSet<Scalar>>& sets, const std::vector<BlockCoord>& occupied) {
    m_runs.assign(occupied.size(), {});
    for (std::size_t body = 0; body < sets.size(); ++body) {
      for (std::size_t i = 0; i < sets[body].runs.size(); ++i)
        m_runs[static_cast<std::size_t>(sets[body].runs[i].block)].emplace_back(body, i);
    }
    for (std::vector<std::int32_t>& colour : m_colours)
      colour.clear();
    for (std::size_t i = 0; i < occupied.size(); ++i)
      m_colours[static_cast<std::size_t>(colour_of(occupied[i]))].push_back(static_cast<std::int32_t>(i));
  }

  const std::vector<Run>& runs(std::size_t block) const { return m_runs[block]; }
  /// Blocks of one colour share no node with each other's halos.
  const std::array<std::vector<std::int32_t>, COLOURS>& colours() const { return m_colours; }

private:
  /// Blocks of one colour are two apart along every axis.
  static int colour_of(const BlockCoord& coord) {
    return static_cast<int>((coord.x & 1) | (coord.y & 1) << 1 | (coord.z & 1) << 2);
  }

  std::vector<std::vector<Run>> m_runs;
  std::array<std::vector<std::int32_t>, COLOURS> m_colours;
};

} // namespace wry::mpm
