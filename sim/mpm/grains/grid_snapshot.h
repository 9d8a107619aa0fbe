#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/base/result.h"
#include "sim/mpm/grid.h"
#include "sim/state/state_archive.h"

namespace wry::mpm {

/// The nodes of a grid that have mass, in single precision: all that grains see of it.
struct GridSnapshot {
  std::vector<BlockCoord> coords;      ///< blocks with such a node
  std::vector<std::uint64_t> occupied; ///< per block: a bit for each of its nodes
  std::vector<float> values;           ///< velocity [m/s] and mass [kg] of those nodes, in order

  /// Nodes, blocks and their coordinates.
  std::size_t bytes() const { return 4 * values.size() + 32 * coords.size(); }
};

template <class Scalar> GridSnapshot snapshot_of(const Grid<Scalar>& grid);

/// A snapshot with its blocks whole again, to be read like a Grid.
class SnapshotGrid {
public:
  explicit SnapshotGrid(const GridSnapshot& snapshot);
  std::size_t block_count() const { return m_coords.size(); }
  const BlockCoord& coord(std::size_t block) const { return m_coords[block]; }
  const float* values(std::size_t block) const { return m_values.data() + block * BLOCK_VALUES; }

private:
  std::vector<BlockCoord> m_coords;
  std::vector<float> m_values;
};

/// One time at which grains were brought up to date, with what carried them.
struct GrainUpdate {
  double time = 0.0, dt = 0.0; ///< of the step: where obstacles were [s]
  std::vector<double> spans;   ///< per body with grains: the time it was brought forward by; 0: not this time [s]
  GridSnapshot grid;
};

/// As named arrays, bit for bit.
void archive_updates(const std::vector<GrainUpdate>& updates, const std::string& prefix, StateArchive& to);
/// Those that archive_updates() wrote under this prefix. Errors: io naming the array that does not fit.
Result<std::vector<GrainUpdate>> restore_updates(const StateArchive& from, const std::string& prefix);

} // namespace wry::mpm
