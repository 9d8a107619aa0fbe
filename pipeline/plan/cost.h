#pragma once

#include "pipeline/plan/scene_plan.h"
#include "sim/fem/fem_simulation.h"

namespace wry::pipeline {

/// Memory, disk and time from the sizes of the meshes, by rates measured on one core with AVX2. What the linear systems
/// cost is added by describe_solver.
CostEstimate estimate_cost(const shots::Shot& shot, const ScenePlan& plan);

/// The share of memory and disk that the linear solver adds once the simulation is built. The estimate of memory
/// becomes at least what that has.
void add_cost_of_solver(CostEstimate& cost, const fem::FemSimulation& built);

/// What a grid takes on the disk each time that mpm.keep_fields keeps it.
double bytes_of_fields(const mpm::MpmPlan& plan);

/// Builds the solver once to learn which linear solver it takes, why, and how much memory. Adds that to the plan.
/// Errors: those of FemSimulation::create.
Status describe_solver(ScenePlan& plan, Isa isa, int threads);

} // namespace wry::pipeline
