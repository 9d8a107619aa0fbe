#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

namespace wry::contact {

template <class Scalar> using Four = Eigen::Array<Scalar, 4, 1>;

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
    return !(below.max(above) > Scalar(0)).any();
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

/// Where a point is, and its way. The fourth entries are zero.
template <class Scalar> struct MovingPoint {
  Four<Scalar> place, way; ///< [m]
};

/// What rounding takes off gaps of places and ways up to so much by coordinate [m]. With u, half a unit: between boxes,
/// each of eight numbers and five operations on at most four times as much is off by u: 13 u of `most`. Along an axis
/// of length one, places and ways are off by u per coordinate, which is 3.5 u together, their products by 3 u of at
/// most 1.8 times as much each, their sum by u of 3.5 times: 18 u; both sides and their difference: 43 u.
template <class Scalar> double rounding_of_boxes(double most) {
  return 32.0 * static_cast<double>(std::numeric_limits<Scalar>::epsilon()) * most;
}

} // namespace wry::contact
