#pragma once

#include <string>

#include "sim/base/types.h"

namespace wry::scene {

/// An unbounded half-space that bodies stay above.
struct PlaneCollider {
  std::string name;
  Vec3 point = Vec3::Zero();   ///< a point on the plane [m]
  Vec3 normal = Vec3::UnitY(); ///< unit, towards the free side
  double friction = 0.0;       ///< Coulomb coefficient
};

} // namespace wry::scene
