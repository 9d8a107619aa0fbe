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

/// Memory, disk and time from the sizes of the meshes, by measured rates.
CostEstimate estimate_cost(const ScenePlan& plan);

/// Builds the solver once to learn which linear solver it takes, why, and how much memory. Adds that to the plan.
/// Errors: those of FemSimulation::create.
Status describe_solver(ScenePlan& plan, Isa isa, int threads);

} // namespace wry::pipeline
