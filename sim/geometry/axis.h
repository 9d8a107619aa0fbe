#pragma once

#include "sim/base/types.h"

namespace wry::geometry {

/// A coordinate axis.
enum class Axis { x, y, z };

/// The axis after it: x -> y -> z -> x.
inline Axis next_axis(Axis axis) {
  return static_cast<Axis>((static_cast<int>(axis) + 1) % 3);
}

/// 0, 1 or 2.
inline int axis_index(Axis axis) {
  return static_cast<int>(axis);
}

/// The unit vector along it.
inline Vec3 axis_direction(Axis axis) {
  return Vec3::Unit(axis_index(axis));
}

} // namespace wry::geometry
