#pragma once

#include <algorithm>
#include <array>
#include <limits>

#include "sim/contact/moving_box.h"
#include "sim/contact/search_kernels.h"

namespace wry::contact {

/// An axis-aligned box [m].
struct Box {
  double low[3];
  double high[3];

  bool meets(const Box& other) const {
    return low[0] <= other.high[0] && other.low[0] <= high[0] && low[1] <= other.high[1] && other.low[1] <= high[1] &&
           low[2] <= other.high[2] && other.low[2] <= high[2];
  }
  void include(const Box& other) {
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], other.low[i]);
      high[i] = std::max(high[i], other.high[i]);
    }
  }
  void grow(double by) {
    for (int i = 0; i < 3; ++i) {
      low[i] -= by;
      high[i] += by;
    }
  }
};

// A pack is the boxes of a tree's node, at most four. To a new one boxes are put by their places; those that were never
// put meet none.

template <class AnyBox> struct PackOf;

struct BoxPack {
  std::array<Box, 4> boxes;
  int count = 0;
};
template <> struct PackOf<Box> { using Type = BoxPack; };

inline void clear(BoxPack& pack) {
  pack.count = 0;
}
inline void put(BoxPack& pack, int lane, const Box& box) {
  pack.boxes[static_cast<std::size_t>(lane)] = box;
  pack.count = std::max(pack.count, lane + 1);
}
inline Box whole(const BoxPack& pack) {
  Box box = pack.boxes[0];
  for (int lane = 1; lane < pack.count; ++lane)
    box.include(pack.boxes[static_cast<std::size_t>(lane)]);
  return box;
}
/// The sides of all, summed.
inline double sizes(const BoxPack& pack) {
  double sum = 0.0;
  for (int lane = 0; lane < pack.count; ++lane) {
    const Box& box = pack.boxes[static_cast<std::size_t>(lane)];
    for (int i = 0; i < 3; ++i)
      sum += box.high[i] - box.low[i];
  }
  return sum;
}
/// A bit per box.
inline unsigned meeting(const BoxPack& pack, const Box& box) {
  unsigned mask = 0;
  for (int lane = 0; lane < pack.count; ++lane)
    mask |= static_cast<unsigned>(pack.boxes[static_cast<std::size_t>(lane)].meets(box)) << lane;
  return mask;
}

template <class T> struct PackOf<MovingBoxOf<T>> { using Type = MovingBoxes<T>; };

template <class T> void clear(MovingBoxes<T>& pack) {
  constexpr T NEVER = std::numeric_limits<T>::infinity();
  for (int i = 0; i < 3; ++i) {
    std::fill_n(pack.low[i], 4, NEVER);
    std::fill_n(pack.high[i], 4, -NEVER);
    std::fill_n(pack.way_low[i], 4, NEVER);
    std::fill_n(pack.way_high[i], 4, -NEVER);
  }
}
template <class T> void put(MovingBoxes<T>& pack, int lane, const MovingBoxOf<T>& box) {
  for (int i = 0; i < 3; ++i) {
    pack.low[i][lane] = box.low[i];
    pack.high[i][lane] = box.high[i];
    pack.way_low[i][lane] = box.way_low[i];
    pack.way_high[i][lane] = box.way_high[i];
  }
}
/// Four numbers of a pack.
template <class T> Eigen::Map<const Four<T>> four(const T* numbers) {
  return Eigen::Map<const Four<T>>(numbers);
}
template <class T> MovingBoxOf<T> whole(const MovingBoxes<T>& pack) {
  MovingBoxOf<T> box = MovingBoxOf<T>::of(Four<T>::Zero(), Four<T>::Zero());
  for (int i = 0; i < 3; ++i) {
    box.low[i] = four(pack.low[i]).minCoeff();
    box.high[i] = four(pack.high[i]).maxCoeff();
    box.way_low[i] = four(pack.way_low[i]).minCoeff();
    box.way_high[i] = four(pack.way_high[i]).maxCoeff();
  }
  return box;
}
template <class T> double sizes(const MovingBoxes<T>& pack) {
  double sum = 0.0;
  for (int i = 0; i < 3; ++i)
    sum += static_cast<double>((four(pack.high[i]) - four(pack.low[i])).max(T(0)).sum());
  return sum;
}

} // namespace wry::contact
