#pragma once

#include <string>

#include "pipeline/plan/scene_plan.h"

namespace wry::pipeline {

/// Each makes of a plan that of the same scene with a part that it leaves out, by the part's defaults, as far as
/// estimate_cost() looks. For telling what leaving it out saves; nobody runs such a plan.
/// @{
void with_microrotations(ScenePlan& plan);
void with_curvature(ScenePlan& plan); ///< of a tenth of the body's size
void with_plane(ScenePlan& plan);     ///< on which every body lies
void with_friction(ScenePlan& plan);
void with_contact_of_bodies(ScenePlan& plan);
void with_contact_within_bodies(ScenePlan& plan);
void with_stiffness_damping(ScenePlan& plan);
void with_reactions(ScenePlan& plan);
void with_point_rotations(ScenePlan& plan);
void with_double_precision(ScenePlan& plan);
void with_semi_implicit_steps(ScenePlan& plan);
void with_grains(ScenePlan& plan);
void with_kept_fields(ScenePlan& plan);
/// @}

/// The same for what a body's material leaves out.
void put_in(ScenePlan& plan, const std::string& body, mpm::LeftOut::Part part);

} // namespace wry::pipeline
