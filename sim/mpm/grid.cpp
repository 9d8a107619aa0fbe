#include "sim/mpm/grid.h"

namespace wry::mpm {

std::size_t BlockCoordHash::operator()(const BlockCoord& coord) const {
  std::uint64_t hash = 0;
  for (const std::int64_t part : {coord.x, coord.y, coord.z}) {
    hash = (hash ^ static_cast<std::uint64_t>(part)) * 0x9E3779B97F4A7C15ULL;
    hash ^= hash >> 29;
  }
  return hash;
}

template <class Scalar> void Grid<Scalar>::build(std::span<const BlockCoord> occupied) {
  m_coords.assign(occupied.begin(), occupied.end());
  m_neighbours.resize(occupied.size());
  BlockIndex index;
  index.reserve(occupied.size() * 3);
  for (std::size_t i = 0; i < occupied.size(); ++i)
    index.emplace(occupied[i], static_cast<std::int32_t>(i));
  for (std::size_t i = 0; i < occupied.size(); ++i) {
    int neighbour = 0;
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int z = -1; z <= 1; ++z) {
          const BlockCoord coord{occupied[i].x + x, occupied[i].y + y, occupied[i].z + z};
          const auto [place, is_new] = index.emplace(coord, static_cast<std::int32_t>(m_coords.size()));
          if (is_new)
            m_coords.push_back(coord);
          m_neighbours[i][neighbour++] = place->second;
        }
      }
    }
  }
  m_values.resize(m_coords.size() * BLOCK_VALUES);
}

template <class Scalar> std::size_t Grid<Scalar>::memory_bytes() const {
  return m_coords.capacity() * sizeof(BlockCoord) + m_neighbours.capacity() * sizeof(m_neighbours[0]) +
         m_values.capacity() * sizeof(Scalar);
}

template class Grid<float>;
template class Grid<double>;

} // namespace wry::mpm
