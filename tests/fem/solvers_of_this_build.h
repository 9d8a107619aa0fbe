#pragma once

#include <vector>

#include "sim/fem/fem_plan.h"

namespace wry::fem {

/// The linear solvers that can be asked for by name: without CHOLMOD only one.
std::vector<LinearSolver> solvers_of_this_build();

} // namespace wry::fem
