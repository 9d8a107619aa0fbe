#include "sim/mpm/grains/grid_snapshot.h"

#include <algorithm>
#include <bit>

#include <fmt/format.h>

namespace wry::mpm {

namespace {

constexpr std::size_t NODES_OF_BLOCK = BLOCK_VALUES / NODE_VALUES;
static_assert(NODES_OF_BLOCK == 64, "a bit for each node");
/// x, y and z of a block, and the low and high half of its bits: numbers that a double holds.
constexpr std::size_t BLOCK_ROW = 5;

double high_half(std::uint64_t bits) {
  return static_cast<double>(bits >> 32);
}
double low_half(std::uint64_t bits) {
  return static_cast<double>(bits & 0xFFFFFFFFU);
}

} // namespace

template <class Scalar> GridSnapshot snapshot_of(const Grid<Scalar>& grid) {
  GridSnapshot snapshot;
  for (std::size_t block = 0; block < grid.block_count(); ++block) {
    const Scalar* values = grid.values(block);
    std::uint64_t occupied = 0;
    for (std::size_t node = 0; node < NODES_OF_BLOCK; ++node) {
      if (!(values[node * NODE_VALUES + 3] > 0))
        continue;
      occupied |= std::uint64_t{1} << node;
      for (std::size_t k = 0; k < NODE_VALUES; ++k)
        snapshot.values.push_back(static_cast<float>(values[node * NODE_VALUES + k]));
    }
    if (occupied == 0)
      continue;
    snapshot.coords.push_back(grid.coord(block));
    snapshot.occupied.push_back(occupied);
  }
  return snapshot;
}
template GridSnapshot snapshot_of(const Grid<float>&);
template GridSnapshot snapshot_of(const Grid<double>&);

SnapshotGrid::SnapshotGrid(const GridSnapshot& snapshot)
    : m_coords(snapshot.coords)
    , m_values(snapshot.coords.size() * BLOCK_VALUES, 0.0F) {
  const float* next = snapshot.values.data();
  for (std::size_t block = 0; block < m_coords.size(); ++block) {
    for (std::size_t node = 0; node < NODES_OF_BLOCK; ++node) {
      if ((snapshot.occupied[block] >> node & 1U) == 0)
        continue;
      std::copy(next, next + NODE_VALUES, m_values.data() + block * BLOCK_VALUES + node * NODE_VALUES);
      next += NODE_VALUES;
    }
  }
}

void archive_updates(const std::vector<GrainUpdate>& updates, const std::string& prefix, StateArchive& to) {
  for (std::size_t i = 0; i < updates.size(); ++i) {
    const GrainUpdate& update = updates[i];
    NamedArray when{fmt::format("{}/{}/when", prefix, i), {update.spans.size() + 2}, {update.time, update.dt}};
    when.values.insert(when.values.end(), update.spans.begin(), update.spans.end());
    const GridSnapshot& grid = update.grid;
    NamedArray blocks{fmt::format("{}/{}/blocks", prefix, i), {grid.coords.size(), BLOCK_ROW}, {}};
    for (std::size_t block = 0; block < grid.coords.size(); ++block) {
      const BlockCoord& coord = grid.coords[block];
      blocks.values.insert(blocks.values.end(),
                           {static_cast<double>(coord.x), static_cast<double>(coord.y), static_cast<double>(coord.z),
                            low_half(grid.occupied[block]), high_half(grid.occupied[block])});
    }
    to.push_back(std::move(when));
    to.push_back(std::move(blocks));
    to.push_back({fmt::format("{}/{}/nodes", prefix, i),
                  {grid.values.size() / NODE_VALUES, NODE_VALUES},
                  std::vector<double>(grid.values.begin(), grid.values.end())});
  }
}

namespace {

const NamedArray* find_array(const StateArchive& from, const std::string& name) {
  const auto found =
      std::find_if(from.begin(), from.end(), [&](const NamedArray& array) { return array.name == name; });
  return found == from.end() ? nullptr : &*found;
}

Result<GridSnapshot> restore_grid(const NamedArray* blocks, const NamedArray* nodes, const std::string& prefix) {
  if (blocks == nullptr || nodes == nullptr || blocks->values.size() % BLOCK_ROW != 0)
    return make_error(ErrorCode::io, "{}: its grid is not there or torn", prefix);
  GridSnapshot grid;
  std::size_t count = 0;
  for (std::size_t at = 0; at < blocks->values.size(); at += BLOCK_ROW) {
    const double* row = blocks->values.data() + at;
    grid.coords.push_back(
        {static_cast<std::int64_t>(row[0]), static_cast<std::int64_t>(row[1]), static_cast<std::int64_t>(row[2])});
    grid.occupied.push_back(static_cast<std::uint64_t>(row[4]) << 32 | static_cast<std::uint64_t>(row[3]));
    count += static_cast<std::size_t>(std::popcount(grid.occupied.back()));
  }
  if (nodes->values.size() != count * NODE_VALUES)
    return make_error(ErrorCode::io, "{}: {} values for {} nodes", prefix, nodes->values.size(), count);
  grid.values.assign(nodes->values.begin(), nodes->values.end());
  return grid;
}

} // namespace

Result<std::vector<GrainUpdate>> restore_updates(const StateArchive& from, const std::string& prefix) {
  std::vector<GrainUpdate> updates;
  for (std::size_t i = 0;; ++i) {
    const std::string name = fmt::format("{}/{}", prefix, i);
    const NamedArray* when = find_array(from, name + "/when");
    if (when == nullptr)
      return updates;
    if (when->values.size() < 2)
      return make_error(ErrorCode::io, "{}/when is torn", name);
    Result<GridSnapshot> grid =
        restore_grid(find_array(from, name + "/blocks"), find_array(from, name + "/nodes"), name);
    if (!grid)
      return grid.error();
    GrainUpdate update{when->values[0], when->values[1], {when->values.begin() + 2, when->values.end()}, {}};
    update.grid = std::move(*grid);
    updates.push_back(std::move(update));
  }
}

} // namespace wry::mpm
