#pragma once

#include <string>
#include <vector>

#include "pipeline/plan/scene_plan.h"

namespace wry::pipeline {

/// What a body's model and elements are known to do badly, with the measured extent (docs/elements.md); empty: nothing.
std::vector<std::string> element_warnings(const fem::FemBody& body, const BodyReport& report);

} // namespace wry::pipeline
