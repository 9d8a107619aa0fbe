#include "sim/base/pack.h"
#include "sim/contact/ccd_batch.h"

// Continuous collision detection by separating planes. For any direction n the gaps n.(a_i - b_j) of a pair's points
// are linear in time, so a direction that separates the pair at one time proves a whole interval, in closed form;
// hopping from interval to interval gives a time that is proven to come before any touch. Rounding enters only the
// gaps, where a bound is taken off. The directions that are tried contain that of the least distance, so that hops
// converge to the touch quadratically.

namespace wry::contact::WRY_ISA {

using wry::WRY_ISA::Bits;
using wry::WRY_ISA::Real;

namespace {

#define WRY_INLINE [[gnu::always_inline]] inline

constexpr int MAX_HOPS = 48;
/// A hop shorter than this share of what is left ends the search.
constexpr double LEAST_HOP = 1e-5;

// One set of helpers for vectors and for single numbers of 113 bits.
using Quad = __float128;

WRY_INLINE bool any(Bits mask) {
  for (int i = 0; i < wry::WRY_ISA::WIDTH; ++i) {
    if (mask[i])
      return true;
  }
  return false;
}
WRY_INLINE bool any(bool value) {
  return value;
}
WRY_INLINE Real magnitude(Real x) {
  return wry::WRY_ISA::abs(x);
}
WRY_INLINE Quad magnitude(Quad x) {
  return x < 0 ? -x : x;
}
WRY_INLINE Real root(Real x) {
  return wry::WRY_ISA::sqrt(x);
}
/// In double: it scales the separation only, where a bound is taken.
WRY_INLINE Quad root(Quad x) {
  return __builtin_sqrt(static_cast<double>(x));
}
template <class T> struct Rounding;
template <> struct Rounding<Real> { static constexpr double UNIT = 0x1p-53; };
template <> struct Rounding<Quad> { static constexpr double UNIT = 0x1p-113; };

template <class T> struct Vec { T x, y, z; };
template <class T> WRY_INLINE Vec<T> operator-(const Vec<T>& a, const Vec<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T> WRY_INLINE Vec<T> scaled(T s, const Vec<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T> WRY_INLINE T dot(const Vec<T>& a, const Vec<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T> WRY_INLINE Vec<T> cross(const Vec<T>& a, const Vec<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// The points of a pair and how they pair up: A points of one against B of the other, 4 in all.
template <class T> struct Pair {
  Vec<T> start[4];
  Vec<T> end[4];
  T separation;
};

template <class T, int A> class Search {
public:
  WRY_INLINE Search(const Pair<T>& pair, T ceiling)
      : m_pair(pair)
      , m_ceiling(ceiling) {}

  WRY_INLINE T run() {
    m_safe = T{};
    T active = T{} + 1.0;
    for (int hop = 0; hop < MAX_HOPS; ++hop) {
      m_best = m_safe;
      for (int k = 0; k < 4; ++k) {
        m_now[k].x = m_pair.start[k].x + m_safe * (m_pair.end[k].x - m_pair.start[k].x);
        m_now[k].y = m_pair.start[k].y + m_safe * (m_pair.end[k].y - m_pair.start[k].y);
        m_now[k].z = m_pair.start[k].z + m_safe * (m_pair.end[k].z - m_pair.start[k].z);
      }
      try_directions();
      const T hopped = m_best - m_safe;
      m_safe = active > 0.0 ? m_best : m_safe;
      active = (hopped > LEAST_HOP * (1.0 - m_safe)) & (m_safe < m_ceiling) ? active : T{};
      if (!any(active > 0.0))
        break;
    }
    return m_safe;
  }

private:
  WRY_INLINE void try_directions() {
    const Vec<T>* p = m_now;
    if constexpr (A == 1) {
      const Vec<T> sides[3] = {p[2] - p[1], p[3] - p[2], p[1] - p[3]};
      const Vec<T> ways[3] = {p[0] - p[1], p[0] - p[2], p[0] - p[3]};
      try_normal(cross(sides[0], sides[2]), ways[0]);
      for (int k = 0; k < 3; ++k)
        try_direction(cross(sides[k], cross(ways[k], sides[k])));
      for (int k = 0; k < 3; ++k)
        try_direction(ways[k]);
    } else {
      const Vec<T> first = p[1] - p[0];
      const Vec<T> second = p[3] - p[2];
      try_normal(cross(first, second), p[0] - p[2]);
      const Vec<T> ways[4] = {p[0] - p[2], p[1] - p[2], p[0] - p[3], p[1] - p[3]};
      try_direction(cross(second, cross(ways[0], second)));
      try_direction(cross(second, cross(ways[1], second)));
      try_direction(cross(first, cross(ways[0], first)));
      try_direction(cross(first, cross(ways[2], first)));
      for (int k = 0; k < 4; ++k)
        try_direction(ways[k]);
    }
  }

  WRY_INLINE void try_normal(const Vec<T>& normal, const Vec<T>& way) {
    const T sign = dot(normal, way) < T{} ? T{} - 1.0 : T{} + 1.0;
    try_direction(scaled(sign, normal));
  }

  /// A bound from below on n.(a - b), whatever was rounded: 5 operations deep.
  WRY_INLINE T gap(const Vec<T>& n, const Vec<T>& a, const Vec<T>& b) const {
    const Vec<T> way = a - b;
    const T size = magnitude(n.x * way.x) + magnitude(n.y * way.y) + magnitude(n.z * way.z);
    return dot(n, way) - (8.0 * Rounding<T>::UNIT) * size;
  }

  /// Extends the proven interval by what the direction n separates.
  WRY_INLINE void try_direction(const Vec<T>& n) {
    // The tiny part stands for products that underflow.
    const T kept = m_pair.separation * root(dot(n, n)) * (1.0 + 0x1p-48) + 1e-290;
    T from = T{} - 1.0;
    T to = T{} + 1.0;
    for (int i = 0; i < A; ++i) {
      for (int j = A; j < 4; ++j) {
        const T before = gap(n, m_pair.start[i], m_pair.start[j]) - kept;
        const T after = gap(n, m_pair.end[i], m_pair.end[j]) - kept;
        // Where the line from `before` to `after` is positive.
        const T crossing = before / (before - after);
        const T earlier = crossing * (1.0 - 0x1p-49);
        const T later = crossing * (1.0 + 0x1p-49);
        const T ends = before > 0.0 ? (after > 0.0 ? T{} + 1.0 : earlier) : (after > 0.0 ? T{} + 1.0 : T{} - 1.0);
        const T begins = before > 0.0 ? T{} - 1.0 : (after > 0.0 ? later : T{} + 2.0);
        to = ends < to ? ends : to;
        from = begins > from ? begins : from;
      }
    }
    m_best = (from < m_safe) & (to > m_best) ? to : m_best;
  }

  const Pair<T>& m_pair;
  T m_ceiling;
  Vec<T> m_now[4];
  T m_safe, m_best;
};

template <int A> void advance(const CcdBatch& batch, double* safe) {
  constexpr int WIDTH = wry::WRY_ISA::WIDTH;
  for (int lane = 0; lane < CCD_LANES; lane += WIDTH) {
    Pair<Real> pair;
    for (int k = 0; k < 4; ++k) {
      pair.start[k] = {wry::WRY_ISA::load(batch.start[k][0] + lane), wry::WRY_ISA::load(batch.start[k][1] + lane),
                       wry::WRY_ISA::load(batch.start[k][2] + lane)};
      pair.end[k] = {wry::WRY_ISA::load(batch.end[k][0] + lane), wry::WRY_ISA::load(batch.end[k][1] + lane),
                     wry::WRY_ISA::load(batch.end[k][2] + lane)};
    }
    pair.separation = wry::WRY_ISA::load(batch.separation + lane);
    const Real answer = Search<Real, A>(pair, wry::WRY_ISA::broadcast(batch.ceiling)).run();
    for (int i = 0; i < WIDTH; ++i)
      safe[lane + i] = answer[i];
  }
}

template <int A> void advance_precisely(const CcdBatch& batch, double* safe) {
  for (int lane = 0; lane < CCD_LANES; ++lane) {
    Pair<Quad> pair;
    for (int k = 0; k < 4; ++k) {
      pair.start[k] = {batch.start[k][0][lane], batch.start[k][1][lane], batch.start[k][2][lane]};
      pair.end[k] = {batch.end[k][0][lane], batch.end[k][1][lane], batch.end[k][2][lane]};
    }
    pair.separation = batch.separation[lane];
    const Quad answer = Search<Quad, A>(pair, batch.ceiling).run();
    // Towards zero: a double near it may lie above.
    const double near = static_cast<double>(answer);
    safe[lane] = answer >= 1 ? 1.0 : near * (1.0 - 0x1p-52);
  }
}

} // namespace

CcdTable ccd_table() {
  return {&advance<1>, &advance<2>, &advance_precisely<1>, &advance_precisely<2>};
}

} // namespace wry::contact::WRY_ISA
