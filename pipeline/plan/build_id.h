#pragma once

#include <string_view>

namespace wry::pipeline {

/// "0.1.0"
std::string_view version();
/// Hash of the sources in sim/: frames of another simulation build are stale.
std::string_view simulation_build();
/// Hash of the sources in render/: pictures of another render build are drawn again.
std::string_view render_build();

} // namespace wry::pipeline
