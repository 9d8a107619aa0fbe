#include "sim/mpm/particle_sort.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace wry::mpm {

namespace {

constexpr int CELLS = BLOCK_SIDE * BLOCK_SIDE * BLOCK_SIDE;
constexpr std::size_t GRAIN = 4096;

/// The first node of a position's three nodes along an axis.
std::int64_t first_node(double position) {
  return static_cast<std::int64_t>(std::nearbyint(position)) - 1;
}

std::int64_t floor_div(std::int64_t a) {
  return a >= 0 ? a / BLOCK_SIDE : -((BLOCK_SIDE - 1 - a) / BLOCK_SIDE);
}

/// Where a particle goes.
struct Destination {
  BlockCoord shift; ///< of blocks
  int cell = 0;     ///< of the new block
};

Destination destination(const Vec3& position) {
  Destination to;
  std::int64_t* shift[3] = {&to.shift.x, &to.shift.y, &to.shift.z};
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t node = first_node(position[axis]);
    *shift[axis] = floor_div(node);
    to.cell = to.cell * BLOCK_SIDE + static_cast<int>(node - *shift[axis] * BLOCK_SIDE);
  }
  return to;
}

bool is_somewhere(const Vec3& position) {
  constexpr double FAR = 1e15; // cells: beyond it doubles cannot tell one from the next
  return position.allFinite() && position.cwiseAbs().maxCoeff() < FAR;
}

BlockCoord operator+(const BlockCoord& a, const BlockCoord& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

/// A sort in progress. Old particles are numbered by their place, added ones behind the last place.
template <class Scalar> class Sorter {
public:
  Sorter(SortedSet<Scalar>& set, std::span<const NewParticle> added, std::int64_t first_identity,
         const Threads& threads)
      : m_set(set)
      , m_added(added)
      , m_first_identity(first_identity)
      , m_threads(threads) {}

  Status sort() {
    if (Status status = find_destinations(); !status)
      return status;
    make_runs();
    move_channels();
    return {};
  }

private:
  static constexpr int WIDTH = TILE_WIDTH<Scalar>;

  struct Item {
    std::int64_t from = 0;   ///< place, or places + index among the added
    std::int32_t bucket = 0; ///< block before sorting of blocks
    std::int32_t cell = 0;
    BlockCoord shift;
  };

  Vec3 position_of(std::int64_t from) const {
    if (from >= m_places)
      return m_added[static_cast<std::size_t>(from - m_places)].position;
    const std::size_t place = static_cast<std::size_t>(from);
    return {m_set.particles.at(Channel::position, place, 0), m_set.particles.at(Channel::position, place, 1),
            m_set.particles.at(Channel::position, place, 2)};
  }

  std::int32_t bucket_of(const BlockCoord& coord) {
    if (!m_coords.empty() && m_coords[static_cast<std::size_t>(m_last)] == coord)
      return m_last;
    const auto [found, is_new] = m_index.emplace(coord, static_cast<std::int32_t>(m_coords.size()));
    if (is_new)
      m_coords.push_back(coord);
    return m_last = found->second;
  }

  Status find_destinations();
  void make_runs();
  void move_channels();

  SortedSet<Scalar>& m_set;
  std::span<const NewParticle> m_added;
  std::int64_t m_first_identity;
  const Threads& m_threads;
  std::int64_t m_places = 0;
  std::vector<Item> m_items;
  std::vector<BlockCoord> m_coords; ///< by bucket
  BlockIndex m_index;
  std::int32_t m_last = 0;
  std::vector<BlockRun> m_runs;
  std::vector<std::int64_t> m_source; ///< per new place
  std::vector<BlockCoord> m_shift;    ///< per new place
};

template <class Scalar> Status Sorter<Scalar>::find_destinations() {
  m_places = static_cast<std::int64_t>(m_set.particles.tiles()) * WIDTH;
  m_items.resize(m_set.count() + m_added.size());
  std::vector<BlockCoord> block_of(m_items.size());
  std::size_t item = 0;
  for (const BlockRun& run : m_set.runs) {
    for (std::int32_t i = 0; i < run.count; ++i, ++item) {
      m_items[item].from = run.first_tile * WIDTH + i;
      block_of[item] = run.coord;
    }
  }
  for (std::size_t i = 0; i < m_added.size(); ++i, ++item) {
    m_items[item].from = m_places + static_cast<std::int64_t>(i);
    block_of[item] = m_added[i].block;
  }
  std::vector<std::int64_t> lost((m_items.size() + GRAIN - 1) / GRAIN, -1);
  m_threads.for_chunks(m_items.size(), GRAIN, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 position = position_of(m_items[i].from);
      if (!is_somewhere(position)) {
        lost[begin / GRAIN] = static_cast<std::int64_t>(i);
        return;
      }
      const Destination to = destination(position);
      m_items[i].cell = to.cell;
      m_items[i].shift = to.shift;
      block_of[i] = block_of[i] + to.shift;
    }
  });
  for (const std::int64_t item_index : lost) {
    if (item_index < 0)
      continue;
    const std::int64_t from = m_items[static_cast<std::size_t>(item_index)].from;
    const std::int64_t identity =
        from >= m_places ? m_first_identity + from - m_places
                         : identity_of(m_set.particles.at(Channel::identity, static_cast<std::size_t>(from), 0));
    return make_error(ErrorCode::solver, "particle {} is nowhere: its position is not finite, or out of all bounds",
                      identity);
  }
  for (std::size_t i = 0; i < m_items.size(); ++i)
    m_items[i].bucket = bucket_of(block_of[i]);
  return {};
}

template <class Scalar> void Sorter<Scalar>::make_runs() {
  std::vector<std::int32_t> order(m_coords.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    order[i] = static_cast<std::int32_t>(i);
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    return m_coords[static_cast<std::size_t>(a)] < m_coords[static_cast<std::size_t>(b)];
  });
  std::vector<std::int64_t> next(m_coords.size() * CELLS, 0);
  for (const Item& item : m_items)
    ++next[static_cast<std::size_t>(item.bucket) * CELLS + static_cast<std::size_t>(item.cell)];
  std::int64_t tiles = 0;
  for (const std::int32_t bucket : order) {
    BlockRun run;
    run.coord = m_coords[static_cast<std::size_t>(bucket)];
    run.first_tile = tiles;
    for (int cell = 0; cell < CELLS; ++cell) {
      std::int64_t& entry = next[static_cast<std::size_t>(bucket) * CELLS + static_cast<std::size_t>(cell)];
      const std::int64_t count = entry;
      entry = tiles * WIDTH + run.count;
      run.count += static_cast<std::int32_t>(count);
    }
    tiles += (run.count + WIDTH - 1) / WIDTH;
    m_runs.push_back(run);
  }
  m_source.assign(static_cast<std::size_t>(tiles) * WIDTH, 0);
  m_shift.resize(m_source.size());
  for (const Item& item : m_items) {
    const std::size_t place = static_cast<std::size_t>(
        next[static_cast<std::size_t>(item.bucket) * CELLS + static_cast<std::size_t>(item.cell)]++);
    m_source[place] = item.from;
    m_shift[place] = item.shift;
  }
  for (const BlockRun& run : m_runs) {
    const std::size_t first = static_cast<std::size_t>(run.first_tile) * WIDTH;
    const std::size_t end = first + static_cast<std::size_t>((run.count + WIDTH - 1) / WIDTH) * WIDTH;
    for (std::size_t place = first + static_cast<std::size_t>(run.count); place < end; ++place) {
      m_source[place] = m_source[place - 1];
      m_shift[place] = m_shift[place - 1];
    }
  }
}

template <class Scalar> void Sorter<Scalar>::move_channels() {
  std::vector<Channel> channels;
  for (int i = 0; i < CHANNEL_COUNT; ++i) {
    if (m_set.particles.has(static_cast<Channel>(i)))
      channels.push_back(static_cast<Channel>(i));
  }
  ParticleSet<Scalar> sorted(channels);
  sorted.resize(m_source.size() / WIDTH);
  m_threads.for_chunks(m_source.size(), GRAIN, [&](std::size_t begin, std::size_t end) {
    for (const Channel channel : channels) {
      for (int component = 0; component < channel_info(channel).components; ++component) {
        for (std::size_t place = begin; place < end; ++place) {
          const std::int64_t from = m_source[place];
          if (from < m_places)
            sorted.at(channel, place, component) =
                m_set.particles.at(channel, static_cast<std::size_t>(from), component);
        }
      }
    }
    for (std::size_t place = begin; place < end; ++place) {
      const std::int64_t from = m_source[place];
      if (from >= m_places)
        sorted.at(Channel::identity, place, 0) = identity_bits<Scalar>(m_first_identity + from - m_places);
      const Vec3 position = position_of(from);
      const std::int64_t shift[3] = {m_shift[place].x, m_shift[place].y, m_shift[place].z};
      for (int axis = 0; axis < 3; ++axis)
        sorted.at(Channel::position, place, axis) =
            static_cast<Scalar>(position[axis] - static_cast<double>(shift[axis] * BLOCK_SIDE));
    }
  });
  m_set.particles = std::move(sorted);
  m_set.runs = std::move(m_runs);
}

} // namespace

template <class Scalar> std::size_t SortedSet<Scalar>::count() const {
  std::size_t sum = 0;
  for (const BlockRun& run : runs)
    sum += static_cast<std::size_t>(run.count);
  return sum;
}

Result<NewParticle> place_in_grid(const Vec3& point, double cell) {
  const Vec3 cells = point / cell;
  if (!is_somewhere(cells))
    return make_error(ErrorCode::bad_input, "the point ({}, {}, {}) m is too far away for a grid of {} m", point.x(),
                      point.y(), point.z(), cell);
  NewParticle particle;
  std::int64_t* coord[3] = {&particle.block.x, &particle.block.y, &particle.block.z};
  for (int axis = 0; axis < 3; ++axis) {
    *coord[axis] = floor_div(first_node(cells[axis]));
    particle.position[axis] = cells[axis] - static_cast<double>(*coord[axis] * BLOCK_SIDE);
  }
  return particle;
}

template <class Scalar>
Status sort_particles(SortedSet<Scalar>& set, std::span<const NewParticle> added, std::int64_t first_identity,
                      const Threads& threads) {
  return Sorter<Scalar>(set, added, first_identity, threads).sort();
}

template <class Scalar> std::vector<BlockCoord> occupied_blocks(std::span<SortedSet<Scalar>> sets) {
  std::vector<BlockCoord> coords;
  for (const SortedSet<Scalar>& set : sets) {
    for (const BlockRun& run : set.runs)
      coords.push_back(run.coord);
  }
  std::sort(coords.begin(), coords.end());
  coords.erase(std::unique(coords.begin(), coords.end()), coords.end());
  for (SortedSet<Scalar>& set : sets) {
    for (BlockRun& run : set.runs)
      run.block = static_cast<std::int32_t>(std::lower_bound(coords.begin(), coords.end(), run.coord) - coords.begin());
  }
  return coords;
}

std::int64_t identity_of(float bits) {
  return std::bit_cast<std::int32_t>(bits);
}
std::int64_t identity_of(double bits) {
  return std::bit_cast<std::int64_t>(bits);
}
template <> float identity_bits<float>(std::int64_t identity) {
  return std::bit_cast<float>(static_cast<std::int32_t>(identity));
}
template <> double identity_bits<double>(std::int64_t identity) {
  return std::bit_cast<double>(identity);
}

template struct SortedSet<float>;
template struct SortedSet<double>;
template Status sort_particles(SortedSet<float>&, std::span<const NewParticle>, std::int64_t, const Threads&);
template Status sort_particles(SortedSet<double>&, std::span<const NewParticle>, std::int64_t, const Threads&);
template std::vector<BlockCoord> occupied_blocks(std::span<SortedSet<float>>);
template std::vector<BlockCoord> occupied_blocks(std::span<SortedSet<double>>);

} // namespace wry::mpm
