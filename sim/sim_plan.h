#pragma once

#include <memory>
#include <vector>

#include "sim/fem/fem_plan.h"
#include "sim/scene/collider.h"

namespace wry {

/// Everything that one shot simulates, immutable: what is not in here costs nothing.
struct SimPlan {
  double fps = 24.0;
  int first_frame = 1; ///< the frame at t = 0
  int last_frame = 1;  ///< simulated to the time of this frame
  Vec3 up = Vec3::UnitY();
  std::vector<std::shared_ptr<const scene::Collider>> colliders; ///< all of them, for pictures and every method
  fem::FemPlan fem;

  /// Time of a frame [s].
  double time_of(int frame) const { return static_cast<double>(frame - first_frame) / fps; }
};

} // namespace wry
