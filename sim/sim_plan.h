#pragma once

#include <memory>
#include <vector>

#include "sim/fem/fem_plan.h"
#include "sim/mpm/mpm_plan.h"
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
  mpm::MpmPlan mpm;

  /// Bodies of a frame stand in this order: solids, then particles. The index of the body of that name, or their
  /// number.
  std::size_t body_index(const std::string& name) const {
    std::size_t index = 0;
    for (const fem::FemBody& body : fem.bodies) {
      if (body.name == name)
        return index;
      ++index;
    }
    for (const mpm::MpmBody& body : mpm.bodies) {
      if (body.name == name)
        return index;
      ++index;
    }
    return index;
  }

  /// Time of a frame [s].
  double time_of(int frame) const { return static_cast<double>(frame - first_frame) / fps; }
};

} // namespace wry
