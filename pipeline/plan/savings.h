#pragma once

#include "pipeline/plan/scene_plan.h"

namespace wry::pipeline {

/// Fills in what each left-out part would take more of, if the scene had it by its defaults: the estimate of that scene
/// less the scene's own. Where a part changes the linear systems their solver is built to learn what it costs. After
/// describe_solver().
void describe_savings(const shots::Shot& shot, ScenePlan& plan, Isa isa, int threads);

} // namespace wry::pipeline
