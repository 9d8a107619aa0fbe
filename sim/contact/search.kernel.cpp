#include <immintrin.h>

#include "sim/base/pack.h"
#include "sim/contact/search_kernels.h"

namespace wry::contact::WRY_ISA {

namespace {

#define WRY_INLINE [[gnu::always_inline]] inline

using wry::WRY_ISA::max;
using wry::WRY_ISA::min;
using wry::WRY_ISA::Pack;
using wry::WRY_ISA::PackTraits;
using wry::WRY_ISA::splat;
using wry::WRY_ISA::sqrt;

/// Shares by which results are moved to the safe side, for the few roundings after the gap itself.
template <class T> constexpr T SLACK = T(1e-6);

// ---- trees ----

/// Numbers for four boxes of a node, as often as they fit 32 bytes: each time for another box that asks. Twice as many
/// make the search slower, measured with AVX-512.
template <class T> constexpr int ASKERS = WRY_ISA_BYTES >= 32 && sizeof(T) == 4 ? 2 : 1;
template <class T, int N> struct Lanes { typedef T Vector __attribute__((vector_size(N * sizeof(T)))); };
template <class T> struct IntegerOf { using Type = std::int32_t; };
template <> struct IntegerOf<double> { using Type = std::int64_t; };
template <class T, int N> using Numbers = typename Lanes<T, N>::Vector;
template <class T, int N> using Masks = typename Lanes<typename IntegerOf<T>::Type, N>::Vector;

/// Four numbers, again and again.
template <class T, int N> WRY_INLINE void repeat(const T* four, Numbers<T, N>& out) {
  if constexpr (sizeof(T) == 4 && N == 8) {
    const __m128 once = _mm_load_ps(four);
    out = __builtin_shufflevector(once, once, 0, 1, 2, 3, 0, 1, 2, 3);
  } else {
    for (int i = 0; i < N; ++i)
      out[i] = four[i % 4];
  }
}
template <int N> WRY_INLINE Masks<float, N> repeat_integers(const std::int32_t* four) {
  Masks<float, 4> once;
  __builtin_memcpy(&once, four, sizeof(once));
  if constexpr (N == 4)
    return once;
  else
    return __builtin_shufflevector(once, once, 0, 1, 2, 3, 0, 1, 2, 3);
}

/// A bit per lane that is set.
template <class T, int N> WRY_INLINE unsigned bits_of(const Masks<T, N>& mask) {
  if constexpr (sizeof(T) == 4 && N == 4) {
    return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(mask)));
#if WRY_ISA_BYTES >= 32
  } else if constexpr (sizeof(T) == 4 && N == 8) {
    return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
#endif
#if WRY_ISA_BYTES >= 64
  } else if constexpr (sizeof(T) == 4 && N == 16) {
    return static_cast<unsigned>(_mm512_movepi32_mask(reinterpret_cast<__m512i>(mask)));
#endif
  } else {
    unsigned bits = 0;
    for (int i = 0; i < N; ++i)
      bits |= (static_cast<unsigned>(mask[i]) & 1U) << i;
    return bits;
  }
}

/// The bounds of boxes by axis.
template <class Vector> struct Bounds { Vector low[3], high[3], way_low[3], way_high[3]; };
template <class T, int N> WRY_INLINE Bounds<Numbers<T, N>> repeat(const MovingBoxes<T>& boxes) {
  Bounds<Numbers<T, N>> bounds;
  for (int i = 0; i < 3; ++i) {
    repeat<T, N>(boxes.low[i], bounds.low[i]);
    repeat<T, N>(boxes.high[i], bounds.high[i]);
    repeat<T, N>(boxes.way_low[i], bounds.way_low[i]);
    repeat<T, N>(boxes.way_high[i], bounds.way_high[i]);
  }
  return bounds;
}

/// A bit per lane whose two boxes may overlap at some time, as far as each axis tells.
template <class T, int N> WRY_INLINE unsigned meeting(const Bounds<Numbers<T, N>>& a, const Bounds<Numbers<T, N>>& b) {
  const Numbers<T, N> zero{};
  Numbers<T, N> gap{};
  for (int i = 0; i < 3; ++i) {
    const Numbers<T, N> way_below = a.way_low[i] - b.way_high[i];
    const Numbers<T, N> way_above = b.way_low[i] - a.way_high[i];
    const Numbers<T, N> below = (a.low[i] - b.high[i]) + (way_below < zero ? way_below : zero);
    const Numbers<T, N> above = (b.low[i] - a.high[i]) + (way_above < zero ? way_above : zero);
    gap = below > gap ? below : gap;
    gap = above > gap ? above : gap;
  }
  return bits_of<T, N>(gap <= zero);
}

constexpr int MOST_LEAVES = sizeof(TreeWalk::leaves) / sizeof(std::int32_t) - 1;

template <class T>
int find_in_tree(const TreeNode<MovingBoxes<T>>* nodes, const TreeQuery<T>& query, TreeWalk& walk, TreeHit* hits,
                 int room) {
  constexpr int AT_ONCE = ASKERS<T>;
  constexpr int N = 4 * AT_ONCE;
  constexpr int ROUNDS = MOST_ASKERS / AT_ONCE;
  Bounds<Numbers<T, 4>> around;
  for (int i = 0; i < 3; ++i) {
    around.low[i] = Numbers<T, 4>{} + query.low[i];
    around.high[i] = Numbers<T, 4>{} + query.high[i];
    around.way_low[i] = Numbers<T, 4>{} + query.way_low[i];
    around.way_high[i] = Numbers<T, 4>{} + query.way_high[i];
  }
  const int rounds = (query.count + AT_ONCE - 1) / AT_ONCE;
  Bounds<Numbers<T, N>> askers[ROUNDS];
  for (int round = 0; round < rounds; ++round) {
    for (int lane = 0; lane < N; ++lane) {
      const int which = round * AT_ONCE + lane / 4;
      const MovingBoxes<T>& boxes = query.boxes[which / 4];
      for (int i = 0; i < 3; ++i) {
        askers[round].low[i][lane] = boxes.low[i][which % 4];
        askers[round].high[i][lane] = boxes.high[i][which % 4];
        askers[round].way_low[i][lane] = boxes.way_low[i][which % 4];
        askers[round].way_high[i][lane] = boxes.way_high[i][which % 4];
      }
    }
  }
  Masks<float, N> after[ROUNDS]; // of the boxes that ask
  std::int32_t least = query.after[0];
  for (int round = 0; round < rounds; ++round) {
    for (int lane = 0; lane < N; ++lane)
      after[round][lane] = query.after[round * AT_ONCE + lane / 4];
  }
  for (int which = 1; which < query.count; ++which)
    least = query.after[which] < least ? query.after[which] : least;
  int found = 0;
  while (walk.depth > 0 || walk.leaf_count > 0) {
    while (walk.leaf_count > 0) {
      if (found + HITS_OF_LEAF > room)
        return found;
      const TreeNode<MovingBoxes<T>>& leaf = nodes[walk.leaves[--walk.leaf_count]];
      const Bounds<Numbers<T, N>> boxes = repeat<T, N>(leaf.pack);
      const Masks<float, N> index = repeat_integers<N>(leaf.child);
      std::uint32_t met = 0;
      for (int round = 0; round < rounds; ++round) {
        const unsigned beyond = bits_of<float, N>(index > after[round]);
        met |= (meeting<T, N>(boxes, askers[round]) & beyond) << (round * N);
      }
      for (; met != 0; met &= met - 1) {
        const int lane = __builtin_ctz(met);
        hits[found++] = {lane / 4, leaf.child[lane % 4]};
      }
    }
    while (walk.depth > 0 && walk.leaf_count + 4 <= MOST_LEAVES) {
      const TreeNode<MovingBoxes<T>>& node = nodes[walk.stack[--walk.depth]];
      const Masks<float, 4> last = repeat_integers<4>(node.last);
      const unsigned met = meeting<T, 4>(repeat<T, 4>(node.pack), around) & bits_of<float, 4>(last > least);
      const unsigned leaves = met & node.leaf_children;
      const unsigned inner = met & ~node.leaf_children;
      for (int lane = 0; lane < 4; ++lane) {
        walk.leaves[walk.leaf_count] = walk.stack[walk.depth] = node.child[lane];
        walk.leaf_count += static_cast<int>(leaves >> lane & 1U);
        walk.depth += static_cast<int>(inner >> lane & 1U);
      }
    }
  }
  return found;
}

// ---- pairs ----

template <class T> constexpr int WIDTH = PackTraits<T>::WIDTH;

template <class T> struct Three { Pack<T> x, y, z; };
template <class T> WRY_INLINE Three<T> operator+(const Three<T>& a, const Three<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T> WRY_INLINE Three<T> operator-(const Three<T>& a, const Three<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T> WRY_INLINE Pack<T> dot(const Three<T>& a, const Three<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// The first three of four numbers, of as many points as a pack has lanes: point i is node[i * PAIR_RECORD].
WRY_INLINE Three<double> gather(const double* rows, const std::int32_t* node) {
  Three<double> values;
  for (int lane = 0; lane < WIDTH<double>; ++lane) {
    const double* row = rows + 8 * static_cast<std::int64_t>(node[lane * PAIR_RECORD]);
    values.x[lane] = row[0];
    values.y[lane] = row[1];
    values.z[lane] = row[2];
  }
  return values;
}
WRY_INLINE Three<float> gather(const float* rows, const std::int32_t* node) {
  // Register r has the rows of points r, r + 4, r + 8, ..: each group of four is transposed in its own quarter.
  const auto four = [&](int lane) {
    return _mm_load_ps(rows + 8 * static_cast<std::int64_t>(node[lane * PAIR_RECORD]));
  };
#if WRY_ISA_BYTES == 64
  const auto row = [&](int r) {
    const __m256 a = __builtin_shufflevector(four(r), four(r + 4), 0, 1, 2, 3, 4, 5, 6, 7);
    const __m256 b = __builtin_shufflevector(four(r + 8), four(r + 12), 0, 1, 2, 3, 4, 5, 6, 7);
    return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  };
#define WRY_LOW 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29
#define WRY_HIGH 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31
#define WRY_FIRST 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29
#define WRY_SECOND 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31
#elif WRY_ISA_BYTES == 32
  const auto row = [&](int r) { return __builtin_shufflevector(four(r), four(r + 4), 0, 1, 2, 3, 4, 5, 6, 7); };
#define WRY_LOW 0, 8, 1, 9, 4, 12, 5, 13
#define WRY_HIGH 2, 10, 3, 11, 6, 14, 7, 15
#define WRY_FIRST 0, 1, 8, 9, 4, 5, 12, 13
#define WRY_SECOND 2, 3, 10, 11, 6, 7, 14, 15
#else
  const auto& row = four;
#define WRY_LOW 0, 4, 1, 5
#define WRY_HIGH 2, 6, 3, 7
#define WRY_FIRST 0, 1, 4, 5
#define WRY_SECOND 2, 3, 6, 7
#endif
  const Pack<float> a = row(0), b = row(1), c = row(2), d = row(3);
  const Pack<float> xy[2] = {__builtin_shufflevector(a, b, WRY_LOW), __builtin_shufflevector(c, d, WRY_LOW)};
  const Pack<float> z[2] = {__builtin_shufflevector(a, b, WRY_HIGH), __builtin_shufflevector(c, d, WRY_HIGH)};
  return {__builtin_shufflevector(xy[0], xy[1], WRY_FIRST), __builtin_shufflevector(xy[0], xy[1], WRY_SECOND),
          __builtin_shufflevector(z[0], z[1], WRY_FIRST)};
}

/// The gap between primitives whose points lie so along an axis.
template <class T, bool EDGES> WRY_INLINE Pack<T> gap_of(const Pack<T> (&points)[4]) {
  const Pack<T> beyond = max(points[2], points[3]);
  return EDGES ? min(points[0], points[1]) - beyond : points[0] - max(points[1], beyond);
}

/// Gaps along a direction of some squared length, as gaps in space from below; -1 where there is no direction.
template <class T> WRY_INLINE Pack<T> proven(Pack<T> gap, Pack<T> squared, T rounding) {
  const Pack<T> in_space = gap / sqrt(squared) * (T(1) - SLACK<T>)-rounding;
  return squared > T(0) ? in_space : splat(T(-1));
}

/// The largest squared difference between the points of the two primitives.
template <class T, bool EDGES> WRY_INLINE Pack<T> largest_between(const Three<T> (&points)[4]) {
  Pack<T> largest{};
  for (int a = 0; a < (EDGES ? 2 : 1); ++a) {
    for (int b = EDGES ? 2 : 1; b < 4; ++b) {
      const Three<T> way = points[a] - points[b];
      largest = max(largest, dot(way, way));
    }
  }
  return largest;
}

/// Records of pairs from `begin` on, as many as a pack has lanes: the last ones are put again where none is left.
template <class T> class Block {
public:
  WRY_INLINE Block(const PairRecords& pairs, int begin)
      : m_left(pairs.count - begin)
      , m_nodes(pairs.nodes + static_cast<std::int64_t>(begin) * PAIR_RECORD) {
    if (m_left >= WIDTH<T>)
      return;
    for (int lane = 0; lane < WIDTH<T>; ++lane) {
      const int from = lane < m_left ? lane : m_left - 1;
      for (int k = 0; k < 4; ++k)
        m_copy[lane * PAIR_RECORD + k] = m_nodes[from * PAIR_RECORD + k];
    }
    m_nodes = m_copy;
  }
  WRY_INLINE int lanes() const { return m_left < WIDTH<T> ? m_left : WIDTH<T>; }
  WRY_INLINE void gather_points(const T* rows, Three<T> (&out)[4]) const {
    for (int k = 0; k < 4; ++k)
      out[k] = gather(rows, m_nodes + k);
  }

private:
  int m_left;
  const std::int32_t* m_nodes;
  std::int32_t m_copy[WIDTH<T> * PAIR_RECORD];
};

template <class T, bool EDGES>
int find_near(const NearQuestion<T>& question, const PairRecords& pairs, NearAnswer<T>* answers) {
  int found = 0;
  for (int begin = 0; begin < pairs.count; begin += WIDTH<T>) {
    const Block<T> block(pairs, begin);
    Three<T> place[4], way[4];
    block.gather_points(question.points, place);
    block.gather_points(question.points + 4, way);

    // Along the direction between the middles. Between start and end the gap is the least of linear functions: never
    // below both.
    Three<T> axis =
        EDGES ? place[0] + place[1] - place[2] - place[3]
              : Three<T>{T(3) * place[0].x, T(3) * place[0].y, T(3) * place[0].z} - place[1] - place[2] - place[3];
    Pack<T> at_start[4], at_end[4];
    for (int k = 0; k < 4; ++k) {
      at_start[k] = dot(axis, place[k]);
      at_end[k] = at_start[k] + dot(axis, way[k]);
    }
    const Pack<T> squared_axis = dot(axis, axis);
    const Pack<T> start_gap = gap_of<T, EDGES>(at_start);
    const Pack<T> least = proven<T>(min(start_gap, gap_of<T, EDGES>(at_end)), squared_axis, question.rounding);

    // At the start also along the direction between the two nearest points, which tells most where primitives lie side
    // by side.
    Three<T> nearest = place[0] - place[2];
    Pack<T> squared_nearest = dot(nearest, nearest);
    for (int a = 0; a < (EDGES ? 2 : 1); ++a) {
      for (int b = EDGES ? 2 : 1; b < 4; ++b) {
        const Three<T> between = place[a] - place[b];
        const Pack<T> squared = dot(between, between);
        const auto nearer = squared < squared_nearest;
        squared_nearest = nearer ? squared : squared_nearest;
        nearest.x = nearer ? between.x : nearest.x;
        nearest.y = nearer ? between.y : nearest.y;
        nearest.z = nearer ? between.z : nearest.z;
      }
    }
    Pack<T> along[4];
    for (int k = 0; k < 4; ++k)
      along[k] = dot(nearest, place[k]);
    const Pack<T> apart = max(max(proven<T>(start_gap, squared_axis, question.rounding),
                                  proven<T>(gap_of<T, EDGES>(along), squared_nearest, question.rounding)),
                              Pack<T>{});

    const Pack<T> approach = sqrt(largest_between<T, EDGES>(way)) * (T(1) + SLACK<T>)+question.rounding;
    const Pack<T> left = apart * (T(1) - SLACK<T>)-question.distance;
    const auto far = (least > question.distance) | ((apart >= question.enough) & (left > approach));
    for (int lane = 0; lane < block.lanes(); ++lane) {
      answers[found] = {begin + lane, apart[lane], approach[lane]};
      found += static_cast<int>(far[lane]) + 1;
    }
  }
  return found;
}

template <bool EDGES> int find_moved(const MovedQuestion& question, const PairRecords& pairs, std::int32_t* out) {
  constexpr int LANES = WIDTH<float>;
  int found = 0;
  for (int begin = 0; begin < pairs.count; begin += LANES) {
    const Block<float> block(pairs, begin);
    Pack<float> nearer{};
    for (int place = 0; place < question.places; ++place) {
      Three<float> way[4];
      block.gather_points(question.ways + 4 * place, way);
      nearer = max(nearer, largest_between<float, EDGES>(way));
    }
    Pack<float> apart{}, taken = splat(question.taken);
    const bool by_reach = question.taken < 0.0F;
    for (int lane = 0; lane < block.lanes(); ++lane) {
      apart[lane] = pairs.apart[(begin + lane) * PAIR_RECORD];
      if (by_reach)
        taken[lane] = pairs.reach[(begin + lane) * PAIR_RECORD];
    }
    const Pack<float> spare = (apart - taken) * (1.0F - SLACK<float>)-question.rounding;
    const Masks<float, LANES> moved = (spare <= 0.0F) | (nearer >= spare * spare);
    for (unsigned bits = bits_of<float, LANES>(moved) & ((1U << block.lanes()) - 1U); bits != 0; bits &= bits - 1)
      out[found++] = begin + __builtin_ctz(bits);
  }
  return found;
}

} // namespace

SearchTable search_table() {
  return {{find_in_tree<float>, find_near<float, false>, find_near<float, true>},
          {find_in_tree<double>, find_near<double, false>, find_near<double, true>},
          find_moved<false>,
          find_moved<true>};
}

} // namespace wry::contact::WRY_ISA
