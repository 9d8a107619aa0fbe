#pragma once

#include "pipeline/plan/scene_plan.h"
#include "pipeline/run/machine.h"

namespace wry::pipeline {

/// What to do about a scene that needs more than there is.
enum class Shortage { refuse, go_on };

/// Refuses a scene that needs more memory or disk than the tightest limit leaves. Errors: out_of_memory, cannot_write;
/// they say what needs how much, how much there is and under whose limit, and which keys of the shot lower the need.
Status require_resources(const std::string& shot, const CostEstimate& cost, double frame_count, const Machine& machine);

} // namespace wry::pipeline
