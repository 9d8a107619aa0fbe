#pragma once

#include "sim/base/pack.h"
#include "sim/mpm/kernels/transfer.h"

/// How a particle and its 27 nodes talk: quadratic B-splines, and sums of rows of nodes along z (spec S6).
namespace wry::mpm::WRY_ISA {

#define WRY_INLINE [[gnu::always_inline]] inline

template <class T> using Pack = wry::WRY_ISA::Pack<T>;
template <class T> constexpr int LANES = wry::WRY_ISA::PackTraits<T>::WIDTH;
template <class T> constexpr int TILE = TILE_WIDTH<T>;

/// Three nodes along z with four values each, in as few packs as hold them; what is beyond the third node has weight 0.
template <class T> constexpr int ROW = (3 * NODE_VALUES + LANES<T> - 1) / LANES<T>;
template <class T> struct Row { Pack<T> part[ROW<T>]; };

template <class T> struct Loose {
  typedef T Vector __attribute__((vector_size(WRY_ISA_BYTES), aligned(sizeof(T)), may_alias));
};

template <class T> WRY_INLINE Pack<T> load_loose(const T* from) {
  return *reinterpret_cast<const typename Loose<T>::Vector*>(from) + Pack<T>{};
}
template <class T> WRY_INLINE void store_loose(T* to, Pack<T> value) {
  *reinterpret_cast<typename Loose<T>::Vector*>(to) = value;
}

/// Four values, repeated for each node of a row.
template <class T> WRY_INLINE Row<T> repeat(const T* four) {
  Row<T> row;
  for (int r = 0; r < ROW<T>; ++r) {
    for (int lane = 0; lane < LANES<T>; ++lane)
      row.part[r][lane] = four[(r * LANES<T> + lane) % NODE_VALUES];
  }
  return row;
}

/// A value per node of a row (the fourth is 0), repeated for the node's values.
template <class T> WRY_INLINE Row<T> per_node(const T* four) {
  Row<T> row;
  for (int r = 0; r < ROW<T>; ++r) {
    for (int lane = 0; lane < LANES<T>; ++lane)
      row.part[r][lane] = four[(r * LANES<T> + lane) / NODE_VALUES];
  }
  return row;
}

template <class T> WRY_INLINE Row<T> operator*(T factor, const Row<T>& row) {
  Row<T> out;
  for (int r = 0; r < ROW<T>; ++r)
    out.part[r] = factor * row.part[r];
  return out;
}
template <class T> WRY_INLINE Row<T> operator*(const Row<T>& a, const Row<T>& b) {
  Row<T> out;
  for (int r = 0; r < ROW<T>; ++r)
    out.part[r] = a.part[r] * b.part[r];
  return out;
}
template <class T> WRY_INLINE Row<T> operator+(const Row<T>& a, const Row<T>& b) {
  Row<T> out;
  for (int r = 0; r < ROW<T>; ++r)
    out.part[r] = a.part[r] + b.part[r];
  return out;
}

/// Sum over the nodes of a row: four values.
template <class T> WRY_INLINE void contract(const Row<T>& row, const Row<T>& weights, T* four) {
  alignas(64) T products[ROW<T> * LANES<T>];
  Pack<T> sum = row.part[0] * weights.part[0];
  if constexpr (LANES<T> >= NODE_VALUES) {
    for (int r = 1; r < ROW<T>; ++r)
      sum += row.part[r] * weights.part[r];
    wry::WRY_ISA::store(products, sum);
    for (int i = 0; i < NODE_VALUES; ++i) {
      four[i] = products[i];
      for (int node = 1; node < LANES<T> / NODE_VALUES; ++node)
        four[i] += products[node * NODE_VALUES + i];
    }
  } else {
    for (int r = 0; r < ROW<T>; ++r)
      wry::WRY_ISA::store(products + r * LANES<T>, row.part[r] * weights.part[r]);
    for (int i = 0; i < NODE_VALUES; ++i)
      four[i] = products[i] + products[NODE_VALUES + i] + products[2 * NODE_VALUES + i];
  }
}

/// Subnormal numbers cost a hundred times a normal one's arithmetic and mean nothing here.
class FlushSubnormals {
public:
  FlushSubnormals()
      : m_before(__builtin_ia32_stmxcsr()) {
    __builtin_ia32_ldmxcsr(m_before | 0x8040u);
  }
  ~FlushSubnormals() { __builtin_ia32_ldmxcsr(m_before); }
  FlushSubnormals(const FlushSubnormals&) = delete;
  FlushSubnormals& operator=(const FlushSubnormals&) = delete;

private:
  unsigned m_before;
};

/// The nearest whole number.
template <class T> WRY_INLINE Pack<T> nearest(Pack<T> x) {
  constexpr T MAGIC = sizeof(T) == sizeof(float) ? T(12582912.0) : T(6755399441055744.0); // 1.5 * 2^23, 2^52
  return (x + MAGIC) - MAGIC;
}

/// Quadratic B-splines of the particles of a tile, an axis after the other.
template <class T> struct Splines {
  alignas(64) T centre[3][TILE<T>];     ///< the middle one of the three nodes
  alignas(64) T from_first[3][TILE<T>]; ///< x minus the first node, in [1/2, 3/2]
  alignas(64) T weight[3][3][TILE<T>];
  alignas(64) T slope[3][3][TILE<T>];           ///< per cell
  alignas(64) T z_weight[TILE<T>][NODE_VALUES]; ///< weight[2], slope[2] by particle; the fourth is 0
  alignas(64) T z_slope[TILE<T>][NODE_VALUES];
  alignas(64) T z_moment[TILE<T>][NODE_VALUES]; ///< weight times the node's number
};

template <class T> WRY_INLINE void evaluate_splines(const T* position, Splines<T>& out) {
  using wry::WRY_ISA::load;
  using wry::WRY_ISA::store;
  for (int axis = 0; axis < 3; ++axis) {
    for (int first = 0; first < TILE<T>; first += LANES<T>) {
      const Pack<T> x = load(position + axis * TILE<T> + first);
      const Pack<T> centre = nearest<T>(x);
      const Pack<T> e = x - centre;
      const Pack<T> low = T(0.5) - e;
      const Pack<T> high = T(0.5) + e;
      store(out.centre[axis] + first, centre);
      store(out.from_first[axis] + first, T(1) + e);
      store(out.weight[axis][0] + first, T(0.5) * low * low);
      store(out.weight[axis][1] + first, T(0.75) - e * e);
      store(out.weight[axis][2] + first, T(0.5) * high * high);
      store(out.slope[axis][0] + first, -low);
      store(out.slope[axis][1] + first, T(-2) * e);
      store(out.slope[axis][2] + first, high);
    }
  }
  for (int p = 0; p < TILE<T>; ++p) {
    for (int k = 0; k < 3; ++k) {
      out.z_weight[p][k] = out.weight[2][k][p];
      out.z_slope[p][k] = out.slope[2][k][p];
      out.z_moment[p][k] = T(k) * out.weight[2][k][p];
    }
    out.z_weight[p][3] = out.z_slope[p][3] = out.z_moment[p][3] = 0;
  }
}

/// Offset in the halo of the first of a particle's nodes.
template <class T> WRY_INLINE int first_node(const Splines<T>& splines, int p) {
  const int x = static_cast<int>(splines.centre[0][p]);
  const int y = static_cast<int>(splines.centre[1][p]);
  const int z = static_cast<int>(splines.centre[2][p]);
  return ((x * HALO_SIDE + y) * HALO_SIDE + z) * NODE_VALUES;
}
constexpr int NEXT_X = HALO_SIDE * HALO_SIDE * NODE_VALUES;
constexpr int NEXT_Y = HALO_SIDE * NODE_VALUES;

/// What a particle gives to the node at (i, j, k) of its 27: w (constant + i x + j y + k z) + dw/dx fx + ...
template <class T> struct Given {
  enum { CONSTANT, X, Y, Z, FORCE_X, FORCE_Y, FORCE_Z, COUNT };
  alignas(64) T row[COUNT][NODE_VALUES];
};

/// Adds w (...) of one particle to its 27 nodes: the sum over the axes is taken apart, so that a row of three nodes
/// along z costs two multiplications.
template <class T, Transfer TRANSFER>
WRY_INLINE void scatter_particle(const Given<T>& given, const Splines<T>& splines, int p, T* halo) {
  using G = Given<T>;
  const Row<T> wz = per_node(splines.z_weight[p]);
  Row<T> along_z = repeat(given.row[G::Z]) * per_node(splines.z_moment[p]);
  if constexpr (TRANSFER == Transfer::gradient)
    along_z = along_z + repeat(given.row[G::FORCE_Z]) * per_node(splines.z_slope[p]);
  const Row<T> constant = repeat(given.row[G::CONSTANT]);
  const Row<T> x = repeat(given.row[G::X]);
  const Row<T> y = repeat(given.row[G::Y]) * wz;
  Row<T> of_x[3];
  Row<T> of_y[3];
  for (int i = 0; i < 3; ++i) {
    const T wx = splines.weight[0][i][p];
    Row<T> value = wx * (constant + T(i) * x);
    if constexpr (TRANSFER == Transfer::gradient)
      value = value + splines.slope[0][i][p] * repeat(given.row[G::FORCE_X]);
    of_x[i] = value * wz + wx * along_z;
  }
  for (int j = 0; j < 3; ++j) {
    of_y[j] = (T(j) * splines.weight[1][j][p]) * y;
    if constexpr (TRANSFER == Transfer::gradient)
      of_y[j] = of_y[j] + splines.slope[1][j][p] * (repeat(given.row[G::FORCE_Y]) * wz);
  }
  T* first = halo + first_node(splines, p);
  for (int i = 0; i < 3; ++i) {
    const T wx = splines.weight[0][i][p];
    for (int j = 0; j < 3; ++j) {
      const T wy = splines.weight[1][j][p];
      T* at = first + i * NEXT_X + j * NEXT_Y;
      for (int r = 0; r < ROW<T>; ++r) {
        const Pack<T> sum = load_loose(at + r * LANES<T>) + wy * of_x[i].part[r] + wx * of_y[j].part[r];
        store_loose<T>(at + r * LANES<T>, sum);
      }
    }
  }
}

/// Sums over a particle's nodes: w v, w v times the node's number along each axis, and dw v.
template <class T> struct Taken {
  enum { VELOCITY, X, Y, Z, SLOPE_X, SLOPE_Y, SLOPE_Z, COUNT };
  alignas(64) T row[COUNT][NODE_VALUES];
};

template <class T, Transfer TRANSFER>
WRY_INLINE void gather_particle(const T* halo, const Splines<T>& splines, int p, Taken<T>& taken) {
  using K = Taken<T>;
  const T* first = halo + first_node(splines, p);
  Row<T> sum{}, moment_x{}, moment_y{}, slope_x{}, slope_y{};
  for (int i = 0; i < 3; ++i) {
    Row<T> plain{}, moment{}, slope{};
    for (int j = 0; j < 3; ++j) {
      const T wy = splines.weight[1][j][p];
      const T dy = splines.slope[1][j][p];
      const T* at = first + i * NEXT_X + j * NEXT_Y;
      for (int r = 0; r < ROW<T>; ++r) {
        const Pack<T> value = load_loose(at + r * LANES<T>);
        plain.part[r] += wy * value;
        if (j > 0)
          moment.part[r] += (T(j) * wy) * value;
        if constexpr (TRANSFER == Transfer::gradient)
          slope.part[r] += dy * value;
      }
    }
    const T wx = splines.weight[0][i][p];
    const T dx = splines.slope[0][i][p];
    for (int r = 0; r < ROW<T>; ++r) {
      sum.part[r] += wx * plain.part[r];
      if (i > 0)
        moment_x.part[r] += (T(i) * wx) * plain.part[r];
      moment_y.part[r] += wx * moment.part[r];
      if constexpr (TRANSFER == Transfer::gradient) {
        slope_x.part[r] += dx * plain.part[r];
        slope_y.part[r] += wx * slope.part[r];
      }
    }
  }
  const Row<T> wz = per_node(splines.z_weight[p]);
  contract(sum, wz, taken.row[K::VELOCITY]);
  contract(moment_x, wz, taken.row[K::X]);
  contract(moment_y, wz, taken.row[K::Y]);
  contract(sum, per_node(splines.z_moment[p]), taken.row[K::Z]);
  if constexpr (TRANSFER == Transfer::gradient) {
    contract(slope_x, wz, taken.row[K::SLOPE_X]);
    contract(slope_y, wz, taken.row[K::SLOPE_Y]);
    contract(sum, per_node(splines.z_slope[p]), taken.row[K::SLOPE_Z]);
  }
}

template <class T> WRY_INLINE Pack<T> lanes_of(const Taken<T>* taken, int row, int component) {
  Pack<T> value;
  for (int lane = 0; lane < LANES<T>; ++lane)
    value[lane] = taken[lane].row[row][component];
  return value;
}

} // namespace wry::mpm::WRY_ISA
