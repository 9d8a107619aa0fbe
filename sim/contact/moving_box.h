#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "sim/contact/ccd.h"

namespace wry::contact {

/// Whether one of four numbers is above zero.
inline bool any_positive(const Eigen::Array4f& numbers) {
  typedef float Floats __attribute__((vector_size(16)));
  typedef std::int64_t Halves __attribute__((vector_size(16)));
  Floats lanes;
  Eigen::Map<Eigen::Array4f, Eigen::Aligned16>(reinterpret_cast<float*>(&lanes)) = numbers;
  const Halves positive = reinterpret_cast<Halves>(lanes > Floats{});
  return (positive[0] | positive[1]) != 0;
}

/// A box whose contents go straight ways, all in the same time from 0 to 1: in single precision, so that who searches
/// has to grow boxes by what rounding may do, `rounding_of_boxes`. The fourth entries are zero.
struct MovingBox {
  Eigen::Array4f low, high;         ///< around all places at time 0 [m]
  Eigen::Array4f way_low, way_high; ///< around all ways [m]

  static MovingBox of(const Eigen::Array4f& place, const Eigen::Array4f& way) { return {place, place, way, way}; }

  /// Whether they may overlap at some time, as far as each axis tells. What moves along with each other only meets
  /// where it met before, however far both go.
  bool meets(const MovingBox& other) const {
    const Eigen::Array4f below = other.low - high + (other.way_low - way_high).min(0.0F);
    const Eigen::Array4f above = low - other.high + (way_low - other.way_high).min(0.0F);
    return !any_positive(below.max(above));
  }
  void include(const MovingBox& other) {
    low = low.min(other.low);
    high = high.max(other.high);
    way_low = way_low.min(other.way_low);
    way_high = way_high.max(other.way_high);
  }
  void grow(double by) {
    low -= static_cast<float>(by);
    high += static_cast<float>(by);
  }
};

/// The direction between the middles of a pair's primitives, not of unit length.
inline Eigen::Array4f middle_axis(PairKind kind, const std::array<Eigen::Array4f, 4>& places) {
  const float share = kind == PairKind::edge_edge ? 1.0F : -1.0F; // the second point is of the first edge
  return (2.0F - share) * places[0] + share * places[1] - places[2] - places[3];
}

/// The gap between primitives along an axis, times its length.
inline float gap_along(PairKind kind, const Eigen::Array4f& axis, const std::array<Eigen::Array4f, 4>& places) {
  std::array<float, 4> along;
  for (std::size_t k = 0; k < 4; ++k)
    along[k] = (axis * places[k]).sum();
  const float beyond = std::max(along[2], along[3]);
  return kind == PairKind::edge_edge ? std::min(along[0], along[1]) - beyond : along[0] - std::max(along[1], beyond);
}

/// What a pair's distance is at least at the start, as the direction between its middles tells: a quick answer.
/// `nodes` are boxes of single points; `rounding` is what it may take off a gap [m].
inline double middle_distance(PairKind kind, const std::array<std::int32_t, 4>& pair,
                              const std::vector<MovingBox>& nodes, double rounding) {
  std::array<Eigen::Array4f, 4> places;
  for (std::size_t k = 0; k < 4; ++k)
    places[k] = nodes[static_cast<std::size_t>(pair[k])].low;
  const Eigen::Array4f axis = middle_axis(kind, places);
  const float length = std::sqrt(axis.square().sum());
  return length > 0.0F ? static_cast<double>(gap_along(kind, axis, places) / length) * (1.0 - 1e-6) - rounding : 0.0;
}

/// Whether a pair stays farther apart than `distance` all the time, as that direction tells.
inline bool stay_apart(PairKind kind, const std::array<std::int32_t, 4>& pair, const std::vector<MovingBox>& nodes,
                       double distance, double rounding) {
  std::array<Eigen::Array4f, 4> start, end;
  for (std::size_t k = 0; k < 4; ++k) {
    const MovingBox& node = nodes[static_cast<std::size_t>(pair[k])];
    start[k] = node.low;
    end[k] = node.low + node.way_low;
  }
  const Eigen::Array4f axis = middle_axis(kind, start);
  const float gap = std::min(gap_along(kind, axis, start), gap_along(kind, axis, end));
  return gap > (distance + rounding) * std::sqrt(axis.square().sum()) * (1.0 + 1e-6);
}

/// What rounding takes off gaps of places and ways up to so much by coordinate [m]. With u, half a unit: between boxes,
/// each of eight numbers and five operations on at most four times as much is off by u: 13 u of `most`. Along an axis,
/// a place at the end is off by 4 u per coordinate and sqrt(3) times that along it, its product with the axis by 4 u of
/// at most 3.5 times as much; both sides and their difference: 49 u.
inline double rounding_of_boxes(double most) {
  return 64.0 * 5.9604645e-8 * most;
}

} // namespace wry::contact
