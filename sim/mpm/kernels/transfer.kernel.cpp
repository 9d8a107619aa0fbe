#include "sim/mpm/kernels/weights.h"

namespace wry::mpm::WRY_ISA {

namespace {

/// For the particles of a tile.
template <class T, Transfer TRANSFER>
WRY_INLINE void prepare_scatter(const TransferRun<T>& run, int tile, const Splines<T>& splines, Given<T>* given) {
  using wry::WRY_ISA::load;
  using wry::WRY_ISA::store;
  constexpr int XX = 0, YY = 1, ZZ = 2, YZ = 3, ZX = 4, XY = 5;
  constexpr int COMPONENT[3][3] = {{XX, XY, ZX}, {XY, YY, YZ}, {ZX, YZ, ZZ}};
  const T* velocity = run.velocity + tile * 3 * TILE<T>;
  const T* affine = run.affine + tile * 9 * TILE<T>;
  const T* stress = run.tiles.stress + tile * 6 * TILE<T>;
  const T momentum_per_cell = run.mass * run.cell;
  const T force = TRANSFER == Transfer::mls ? -run.dt * run.volume * T(4) / run.cell : -run.dt * run.volume / run.cell;
  alignas(64) T lanes[LANES<T>];
  for (int c = 0; c < 3; ++c) {
    for (int first = 0; first < TILE<T>; first += LANES<T>) {
      const auto put = [&](int row, Pack<T> value) {
        store(lanes, value);
        for (int lane = 0; lane < LANES<T>; ++lane)
          given[first + lane].row[row][c] = lanes[lane];
      };
      Pack<T> constant = run.mass * load(velocity + c * TILE<T> + first);
      for (int a = 0; a < 3; ++a) {
        Pack<T> slope = momentum_per_cell * load(affine + (c * 3 + a) * TILE<T> + first);
        const Pack<T> pull = force * load(stress + COMPONENT[c][a] * TILE<T> + first);
        if constexpr (TRANSFER == Transfer::mls)
          slope += pull;
        else
          put(Given<T>::FORCE_X + a, pull);
        put(Given<T>::X + a, slope);
        constant -= slope * load(splines.from_first[a] + first);
      }
      put(Given<T>::CONSTANT, constant);
    }
  }
}

template <class T, Transfer TRANSFER> void scatter(const TransferRun<T>& run, T* halo) {
  const FlushSubnormals flush;
  Splines<T> splines;
  Given<T> given[TILE<T>] = {};
  for (int p = 0; p < TILE<T>; ++p)
    given[p].row[Given<T>::CONSTANT][3] = run.mass;
  for (int tile = 0; tile * TILE<T> < run.count; ++tile) {
    evaluate_splines(run.position + tile * 3 * TILE<T>, splines);
    prepare_scatter<T, TRANSFER>(run, tile, splines, given);
    const int left = run.count - tile * TILE<T>;
    const int live = left < TILE<T> ? left : TILE<T>;
    for (int p = 0; p < live; ++p)
      scatter_particle<T, TRANSFER>(given[p], splines, p, halo);
  }
}

/// Greatest and summed values over the lanes of a run, until it is done.
template <class T> struct Extremes {
  Pack<T> speed{}, gradient{}, sum{};
  T outside = 0; ///< not 0: a particle has left the halo
};

template <class T, Transfer TRANSFER>
WRY_INLINE void finish_gather(const TransferRun<T>& run, int tile, int live, const Splines<T>& splines,
                              const Taken<T>* taken, T* gradient, Extremes<T>& extremes) {
  using wry::WRY_ISA::load;
  using wry::WRY_ISA::max;
  using wry::WRY_ISA::store;
  using K = Taken<T>;
  T* position = run.position + tile * 3 * TILE<T>;
  T* velocity = run.velocity + tile * 3 * TILE<T>;
  T* affine = run.affine + tile * 9 * TILE<T>;
  const T per_cell = T(4) / run.cell;
  const T per_length = T(1) / run.cell;
  const T cells = run.dt / run.cell;
  for (int first = 0; first < TILE<T>; first += LANES<T>) {
    Pack<T> speed{}, norm{};
    for (int c = 0; c < 3; ++c) {
      const Pack<T> v = lanes_of(taken + first, K::VELOCITY, c);
      for (int a = 0; a < 3; ++a) {
        const Pack<T> moment = lanes_of(taken + first, K::X + a, c) - v * load(splines.from_first[a] + first);
        const Pack<T> spin = per_cell * moment;
        store(affine + (c * 3 + a) * TILE<T> + first, spin);
        Pack<T> slope = spin;
        if constexpr (TRANSFER == Transfer::gradient) {
          slope = per_length * lanes_of(taken + first, K::SLOPE_X + a, c);
          store(gradient + (c * 3 + a) * TILE<T> + first, slope);
        }
        norm += slope * slope;
      }
      speed += v * v;
      store(velocity + c * TILE<T> + first, v);
      store(position + c * TILE<T> + first, load(position + c * TILE<T> + first) + cells * v);
    }
    extremes.speed = max(extremes.speed, speed);
    extremes.gradient = max(extremes.gradient, norm);
    for (int lane = 0; lane < LANES<T>; ++lane)
      extremes.sum[lane] += first + lane < live ? speed[lane] : T(0);
  }
  for (int i = 0; i < 3 * TILE<T>; ++i) {
    const bool inside = position[i] >= T(LEAST_POSITION) && position[i] < T(POSITION_END);
    extremes.outside += inside ? T(0) : T(1);
  }
}

template <class T> WRY_INLINE ConstitutiveTiles<T> one_tile(const TransferRun<T>& run, int tile) {
  ConstitutiveTiles<T> tiles;
  tiles.count = 1;
  tiles.dt = run.dt;
  tiles.affine = run.affine + tile * 9 * TILE<T>;
  tiles.deformation = run.tiles.deformation + tile * 9 * TILE<T>;
  tiles.stress = run.tiles.stress + tile * 6 * TILE<T>;
  for (int i = 0; i < CHANNEL_COUNT; ++i) {
    T* first = run.tiles.state[i];
    tiles.state[i] = first ? first + tile * CHANNELS[i].components * TILE<T> : nullptr;
  }
  return tiles;
}

template <class T, Transfer TRANSFER> GatherReport gather(const TransferRun<T>& run, const T* halo) {
  const FlushSubnormals flush;
  GatherReport report;
  Extremes<T> extremes;
  Splines<T> splines;
  Taken<T> taken[TILE<T>];
  alignas(64) T gradient[9 * TILE<T>];
  for (int tile = 0; tile * TILE<T> < run.count; ++tile) {
    evaluate_splines(run.position + tile * 3 * TILE<T>, splines);
    const int left = run.count - tile * TILE<T>;
    const int live = left < TILE<T> ? left : TILE<T>;
    for (int p = 0; p < live; ++p)
      gather_particle<T, TRANSFER>(halo, splines, p, taken[p]);
    for (int p = live; p < TILE<T>; ++p)
      taken[p] = taken[live - 1];
    finish_gather<T, TRANSFER>(run, tile, live, splines, taken, gradient, extremes);
    ConstitutiveTiles<T> tiles = one_tile(run, tile);
    tiles.velocity_gradient = TRANSFER == Transfer::gradient ? gradient : tiles.affine;
    report.material.add(run.update(*run.material, tiles), tile * TILE<T>);
  }
  for (int lane = 0; lane < LANES<T>; ++lane) {
    const double speed = extremes.speed[lane];
    const double norm = extremes.gradient[lane];
    report.max_speed_squared = speed > report.max_speed_squared ? speed : report.max_speed_squared;
    report.max_gradient_squared = norm > report.max_gradient_squared ? norm : report.max_gradient_squared;
    report.sum_speed_squared += extremes.sum[lane];
  }
  report.strayed = extremes.outside != T(0);
  return report;
}

/// Nodes of a halo along one axis, by the block they are in: {first in the halo, first in the block, how many}.
struct Span {
  int halo, block, count;
};
constexpr Span SPANS[3] = {{0, BLOCK_SIDE - 1, 1}, {1, 0, BLOCK_SIDE}, {1 + BLOCK_SIDE, 0, 3}};

/// Calls visit(block, offset in the halo, offset in the block, values) for every straight piece of the halo.
template <class Visit> WRY_INLINE void for_pieces(const Visit& visit) {
  for (int bx = 0; bx < 3; ++bx) {
    for (int by = 0; by < 3; ++by) {
      for (int bz = 0; bz < 3; ++bz) {
        const int block = (bx * 3 + by) * 3 + bz;
        for (int x = 0; x < SPANS[bx].count; ++x) {
          for (int y = 0; y < SPANS[by].count; ++y) {
            const int halo = ((SPANS[bx].halo + x) * HALO_SIDE + SPANS[by].halo + y) * HALO_SIDE + SPANS[bz].halo;
            const int node = ((SPANS[bx].block + x) * BLOCK_SIDE + SPANS[by].block + y) * BLOCK_SIDE + SPANS[bz].block;
            visit(block, halo * NODE_VALUES, node * NODE_VALUES, SPANS[bz].count * NODE_VALUES);
          }
        }
      }
    }
  }
}

template <class T> void add_halo(const T* halo, T* const* blocks) {
  for_pieces([&](int block, int from, int to, int values) {
    T* out = blocks[block] + to;
    for (int i = 0; i < values; ++i)
      out[i] += halo[from + i];
  });
}

template <class T> void read_halo(const T* const* blocks, T* halo) {
  for_pieces([&](int block, int to, int from, int values) {
    const T* in = blocks[block] + from;
    for (int i = 0; i < values; ++i)
      halo[to + i] = in[i];
  });
}

template <class T> constexpr TransferKernels<T> kernels() {
  return {{scatter<T, Transfer::gradient>, scatter<T, Transfer::mls>},
          {gather<T, Transfer::gradient>, gather<T, Transfer::mls>},
          add_halo<T>,
          read_halo<T>};
}

} // namespace

extern const TransferKernels<float> transfers_float;
extern const TransferKernels<double> transfers_double;
constinit const TransferKernels<float> transfers_float = kernels<float>();
constinit const TransferKernels<double> transfers_double = kernels<double>();

} // namespace wry::mpm::WRY_ISA
