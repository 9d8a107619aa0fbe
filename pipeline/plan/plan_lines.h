#pragma once

#include <string>

#include "pipeline/plan/scene_plan.h"

namespace wry::pipeline {

/// "micropolar, E 5e+04 Pa, nu 0.4, mu_c/mu 1, L_c 1 m, orthotropic curvature"
std::string describe_material(const fem::FemMaterial& material);

/// What a body's elements are, unless they are linear tets: ", plate of ...", to follow its material.
std::string describe_elements(const fem::FemBody& body);

/// Fills plan.runs, plan.left_out and plan.warnings.
void describe_plan(const shots::Shot& shot, ScenePlan& plan);

} // namespace wry::pipeline
