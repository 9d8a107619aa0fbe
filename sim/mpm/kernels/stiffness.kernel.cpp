#include "sim/mpm/kernels/weights.h"

/// The stiffness of the matter as an operator on velocities of the grid, for semi-implicit steps (spec S6).
namespace wry::mpm::WRY_ISA {

namespace {

/// Sums over a particle's nodes of dw v alone.
template <class T> WRY_INLINE void gather_slopes(const T* halo, const Splines<T>& splines, int p, Taken<T>& taken) {
  using K = Taken<T>;
  const T* first = halo + first_node(splines, p);
  Row<T> sum{}, slope_x{}, slope_y{};
  for (int i = 0; i < 3; ++i) {
    Row<T> plain{}, slope{};
    for (int j = 0; j < 3; ++j) {
      const T wy = splines.weight[1][j][p];
      const T dy = splines.slope[1][j][p];
      const T* at = first + i * NEXT_X + j * NEXT_Y;
      for (int r = 0; r < ROW<T>; ++r) {
        const Pack<T> value = load_loose(at + r * LANES<T>);
        plain.part[r] += wy * value;
        slope.part[r] += dy * value;
      }
    }
    const T wx = splines.weight[0][i][p];
    const T dx = splines.slope[0][i][p];
    for (int r = 0; r < ROW<T>; ++r) {
      sum.part[r] += wx * plain.part[r];
      slope_x.part[r] += dx * plain.part[r];
      slope_y.part[r] += wx * slope.part[r];
    }
  }
  const Row<T> wz = per_node(splines.z_weight[p]);
  contract(slope_x, wz, taken.row[K::SLOPE_X]);
  contract(slope_y, wz, taken.row[K::SLOPE_Y]);
  contract(sum, per_node(splines.z_slope[p]), taken.row[K::SLOPE_Z]);
}

/// Adds dw/dx fx + dw/dy fy + dw/dz fz of one particle to its nodes.
template <class T> WRY_INLINE void scatter_forces(const Given<T>& given, const Splines<T>& splines, int p, T* halo) {
  using G = Given<T>;
  const Row<T> wz = per_node(splines.z_weight[p]);
  const Row<T> of_z = repeat(given.row[G::FORCE_Z]) * per_node(splines.z_slope[p]);
  const Row<T> in_x = repeat(given.row[G::FORCE_X]) * wz;
  const Row<T> in_y = repeat(given.row[G::FORCE_Y]) * wz;
  T* first = halo + first_node(splines, p);
  for (int i = 0; i < 3; ++i) {
    const T wx = splines.weight[0][i][p];
    const Row<T> of_x = splines.slope[0][i][p] * in_x + wx * of_z;
    const Row<T> of_y = wx * in_y;
    for (int j = 0; j < 3; ++j) {
      const T wy = splines.weight[1][j][p];
      const T dy = splines.slope[1][j][p];
      T* at = first + i * NEXT_X + j * NEXT_Y;
      for (int r = 0; r < ROW<T>; ++r)
        store_loose<T>(at + r * LANES<T>, load_loose(at + r * LANES<T>) + wy * of_x.part[r] + dy * of_y.part[r]);
    }
  }
}

/// sym grad v of a tile's particles, six components.
template <class T, Transfer TRANSFER>
WRY_INLINE void strain_rates(const TransferRun<T>& run, const Splines<T>& splines, const Taken<T>* taken, T* rate) {
  using wry::WRY_ISA::load;
  using wry::WRY_ISA::store;
  using K = Taken<T>;
  constexpr int PAIR[6][2] = {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {2, 0}, {0, 1}};
  for (int first = 0; first < TILE<T>; first += LANES<T>) {
    const auto slope = [&](int c, int a) -> Pack<T> {
      if constexpr (TRANSFER == Transfer::gradient)
        return (T(1) / run.cell) * lanes_of(taken + first, K::SLOPE_X + a, c);
      const Pack<T> v = lanes_of(taken + first, K::VELOCITY, c);
      const Pack<T> moment = lanes_of(taken + first, K::X + a, c);
      return (T(4) / run.cell) * (moment - v * load(splines.from_first[a] + first));
    };
    for (int s = 0; s < 6; ++s) {
      const int c = PAIR[s][0], a = PAIR[s][1];
      store(rate + s * TILE<T> + first, c == a ? slope(c, a) : T(0.5) * (slope(c, a) + slope(a, c)));
    }
  }
}

/// What the particles of a tile give to their nodes.
template <class T, Transfer TRANSFER>
WRY_INLINE void prepare_forces(const TransferRun<T>& run, const Splines<T>& splines, const T* stress, Given<T>* given) {
  using wry::WRY_ISA::load;
  using wry::WRY_ISA::store;
  constexpr int COMPONENT[3][3] = {{0, 5, 4}, {5, 1, 3}, {4, 3, 2}};
  const T force = (TRANSFER == Transfer::mls ? T(4) : T(1)) * run.volume / run.cell;
  alignas(64) T lanes[LANES<T>];
  for (int c = 0; c < 3; ++c) {
    for (int first = 0; first < TILE<T>; first += LANES<T>) {
      const auto put = [&](int row, Pack<T> value) {
        store(lanes, value);
        for (int lane = 0; lane < LANES<T>; ++lane)
          given[first + lane].row[row][c] = lanes[lane];
      };
      Pack<T> constant{};
      for (int a = 0; a < 3; ++a) {
        const Pack<T> pull = force * load(stress + COMPONENT[c][a] * TILE<T> + first);
        put((TRANSFER == Transfer::mls ? Given<T>::X : Given<T>::FORCE_X) + a, pull);
        constant -= pull * load(splines.from_first[a] + first);
      }
      if constexpr (TRANSFER == Transfer::mls)
        put(Given<T>::CONSTANT, constant);
    }
  }
}

template <class T, Transfer TRANSFER> void stiffness(const TransferRun<T>& run, const T* velocities, T* forces) {
  const FlushSubnormals flush;
  Splines<T> splines;
  Taken<T> taken[TILE<T>] = {};
  Given<T> given[TILE<T>] = {};
  alignas(64) T rate[6 * TILE<T>];
  for (int tile = 0; tile * TILE<T> < run.count; ++tile) {
    evaluate_splines(run.position + tile * 3 * TILE<T>, splines);
    const int left = run.count - tile * TILE<T>;
    const int live = left < TILE<T> ? left : TILE<T>;
    for (int p = 0; p < live; ++p) {
      if constexpr (TRANSFER == Transfer::gradient)
        gather_slopes<T>(velocities, splines, p, taken[p]);
      else
        gather_particle<T, TRANSFER>(velocities, splines, p, taken[p]);
    }
    strain_rates<T, TRANSFER>(run, splines, taken, rate);
    run.tangent->stress(*run.material, run.frozen + tile * run.tangent->components * TILE<T>, rate);
    prepare_forces<T, TRANSFER>(run, splines, rate, given);
    for (int p = 0; p < live; ++p) {
      if constexpr (TRANSFER == Transfer::gradient)
        scatter_forces<T>(given[p], splines, p, forces);
      else
        scatter_particle<T, TRANSFER>(given[p], splines, p, forces);
    }
  }
}

} // namespace

extern const StiffnessKernels<float> stiffness_float;
extern const StiffnessKernels<double> stiffness_double;
constinit const StiffnessKernels<float> stiffness_float = {
    {stiffness<float, Transfer::gradient>, stiffness<float, Transfer::mls>}};
constinit const StiffnessKernels<double> stiffness_double = {
    {stiffness<double, Transfer::gradient>, stiffness<double, Transfer::mls>}};

} // namespace wry::mpm::WRY_ISA
