#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>
#include <pmmintrin.h>

#include "sim/contact/ccd.h"

namespace wry::contact {

template <class Scalar> using Four = Eigen::Array<Scalar, 4, 1>;

/// Whether one of four numbers is above zero.
inline bool any_positive(const Eigen::Array4d& numbers) {
  return (numbers > 0.0).any();
}
inline bool any_positive(const Eigen::Array4f& numbers) {
  return _mm_movemask_ps(_mm_cmpgt_ps(_mm_load_ps(numbers.data()), _mm_setzero_ps())) != 0;
}
inline bool all_below(const Eigen::Array4f& numbers, float limit) {
  return _mm_movemask_ps(_mm_cmplt_ps(_mm_load_ps(numbers.data()), _mm_set1_ps(limit))) == 15;
}

/// A box whose contents go straight ways, all in the same time from 0 to 1. Who searches has to grow boxes by what
/// rounding may do, `rounding_of_boxes`. The fourth entries are zero.
template <class Scalar> struct MovingBoxOf {
  Four<Scalar> low, high;         ///< around all places at time 0 [m]
  Four<Scalar> way_low, way_high; ///< around all ways [m]

  static MovingBoxOf of(const Four<Scalar>& place, const Four<Scalar>& way) { return {place, place, way, way}; }

  /// Whether they may overlap at some time, as far as each axis tells. What moves along with each other only meets
  /// where it met before, however far both go.
  bool meets(const MovingBoxOf& other) const {
    const Four<Scalar> below = other.low - high + (other.way_low - way_high).min(Scalar(0));
    const Four<Scalar> above = low - other.high + (way_low - other.way_high).min(Scalar(0));
    return !any_positive(Four<Scalar>(below.max(above)));
  }
  void include(const MovingBoxOf& other) {
    low = low.min(other.low);
    high = high.max(other.high);
    way_low = way_low.min(other.way_low);
    way_high = way_high.max(other.way_high);
  }
  void grow(double by) {
    low -= static_cast<Scalar>(by);
    high += static_cast<Scalar>(by);
  }
};

/// In single precision four numbers are looked at together. Where a scene is so large that it tells nothing: double.
using MovingBox = MovingBoxOf<float>;
using WideMovingBox = MovingBoxOf<double>;

/// The direction between the middles of a pair's primitives, not of unit length.
template <class Scalar> Four<Scalar> middle_axis(PairKind kind, const std::array<Four<Scalar>, 4>& places) {
  const Scalar share = kind == PairKind::edge_edge ? Scalar(1) : Scalar(-1); // the second point is of the first edge
  return (Scalar(2) - share) * places[0] + share * places[1] - places[2] - places[3];
}

template <class Scalar> Four<Scalar> sums_of(const std::array<Four<Scalar>, 4>& terms) {
  return {terms[0].sum(), terms[1].sum(), terms[2].sum(), terms[3].sum()};
}
inline Eigen::Array4f sums_of(const std::array<Eigen::Array4f, 4>& terms) {
  const auto load = [&](std::size_t k) { return _mm_load_ps(terms[k].data()); };
  Eigen::Array4f sums;
  _mm_store_ps(sums.data(), _mm_hadd_ps(_mm_hadd_ps(load(0), load(1)), _mm_hadd_ps(load(2), load(3))));
  return sums;
}

/// The products of four places with an axis.
template <class Scalar> Four<Scalar> along(const Four<Scalar>& axis, const std::array<Four<Scalar>, 4>& places) {
  return sums_of(std::array<Four<Scalar>, 4>{axis * places[0], axis * places[1], axis * places[2], axis * places[3]});
}
template <class Scalar> Four<Scalar> squares_of(const std::array<Four<Scalar>, 4>& ways) {
  return sums_of(std::array<Four<Scalar>, 4>{ways[0].square(), ways[1].square(), ways[2].square(), ways[3].square()});
}

/// The gap between primitives whose points lie so along an axis.
template <class Scalar> Scalar gap_of(PairKind kind, const Four<Scalar>& points) {
  const Scalar beyond = std::max(points[2], points[3]);
  return kind == PairKind::edge_edge ? std::min(points[0], points[1]) - beyond
                                     : points[0] - std::max(points[1], beyond);
}

/// How far apart a pair is at least [m], as one direction tells: a quick answer. Below zero where it tells nothing.
struct QuickGap {
  double start = -1.0;
  double least = -1.0; ///< all the time
};

/// Where a point is, and its way. The fourth entries are zero.
template <class Scalar> struct MovingPoint {
  Four<Scalar> place, way; ///< [m]
};

/// Places and ways of a pair's points.
template <class Scalar> class QuickPair {
public:
  QuickPair(PairKind kind, const std::array<std::int32_t, 4>& pair, const std::vector<MovingPoint<Scalar>>& nodes)
      : m_kind(kind) {
    for (std::size_t k = 0; k < 4; ++k)
      m_places[k] = nodes[static_cast<std::size_t>(pair[k])].place;
    const Four<Scalar> axis = middle_axis(m_kind, m_places);
    const Four<Scalar> start = along(axis, m_places);
    const Four<Scalar> end =
        start +
        along(axis, {nodes[static_cast<std::size_t>(pair[0])].way, nodes[static_cast<std::size_t>(pair[1])].way,
                     nodes[static_cast<std::size_t>(pair[2])].way, nodes[static_cast<std::size_t>(pair[3])].way});
    // Between start and end the gap is the least of linear functions: never below both.
    m_at_start = gap_of<Scalar>(m_kind, start);
    m_least = std::min(m_at_start, gap_of<Scalar>(m_kind, end));
    m_squared_length = axis.square().sum();
  }

  /// Whether between_middles().least is above a distance, without its root and division; no where that is close.
  bool is_beyond(double distance, double rounding) const {
    const auto limit = static_cast<Scalar>((distance + rounding) * (1.0 + 1e-5));
    return m_least > Scalar(0) && m_least * m_least > limit * limit * m_squared_length && limit > Scalar(0);
  }
  /// Along the direction between the middles at the start. `rounding` is what it may take off a gap [m].
  QuickGap between_middles(double rounding) const {
    const Scalar length = std::sqrt(m_squared_length);
    if (!(length > Scalar(0)))
      return {};
    return {shrunk(m_at_start / length, rounding), shrunk(m_least / length, rounding)};
  }

  /// At the start, along the direction between the two nearest points: it tells most where primitives lie side by side.
  double between_nearest(double rounding) const {
    const bool edges = m_kind == PairKind::edge_edge;
    const Four<Scalar>& other = m_places[edges ? 1 : 0];
    const std::array<Four<Scalar>, 4> ways = {m_places[0] - m_places[2], m_places[0] - m_places[3],
                                              other - m_places[edges ? 2 : 1], other - m_places[3]};
    const Four<Scalar> squares = squares_of(ways);
    int nearest = 0;
    const Scalar squared = squares.minCoeff(&nearest);
    if (!(squared > Scalar(0)))
      return -1.0;
    const Four<Scalar> points = along(ways[static_cast<std::size_t>(nearest)], m_places);
    return shrunk(gap_of<Scalar>(m_kind, points) / std::sqrt(squared), rounding);
  }

private:
  static double shrunk(Scalar gap, double rounding) { return static_cast<double>(gap) * (1.0 - 1e-6) - rounding; }

  PairKind m_kind;
  std::array<Four<Scalar>, 4> m_places;
  Scalar m_at_start, m_least, m_squared_length; ///< gaps along the direction between the middles, times its length
};

/// What rounding takes off gaps of places and ways up to so much by coordinate [m]. With u, half a unit: between boxes,
/// each of eight numbers and five operations on at most four times as much is off by u: 13 u of `most`. Along an axis
/// of length one, places and ways are off by u per coordinate, which is 3.5 u together, their products by 3 u of at
/// most 1.8 times as much each, their sum by u of 3.5 times: 18 u; both sides and their difference: 43 u.
template <class Scalar> double rounding_of_boxes(double most) {
  return 32.0 * static_cast<double>(std::numeric_limits<Scalar>::epsilon()) * most;
}

} // namespace wry::contact
