#pragma once

#include "sim/base/result.h"
#include "sim/sim_plan.h"
#include "sim/state/frame.h"

namespace wry::pipeline {

/// Adds the surfaces of the plan's colliders behind the simulated bodies, in the order of the plan. Planes have none.
/// Errors: bad_input for a shape that cannot be cut into triangles.
Status add_colliders(const SimPlan& plan, SceneStatic& scene);

/// Adds where the colliders are at the frame's time, in the same order.
void add_collider_poses(const SimPlan& plan, Frame& frame);

} // namespace wry::pipeline
