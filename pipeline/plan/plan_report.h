#pragma once

#include <string>

#include "pipeline/plan/scene_plan.h"

namespace wry::pipeline {

/// What `wry plan` prints: bodies with their meshes, what runs, what is left out and why, memory, disk, time.
std::string plan_text(const ScenePlan& plan);

/// The same as JSON, for plan.json and --json.
std::string plan_json(const ScenePlan& plan);

} // namespace wry::pipeline
