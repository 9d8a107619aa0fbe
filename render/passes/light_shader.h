#pragma once

#include <string>

#include "render/passes/light_state.h"
#include "render/view.h"

namespace wry::render {

/// Fragment shader that shades the subject's pixels; the number of lights and which one casts are fixed in it.
std::string subject_fragment_shader(const RenderPlan& plan, const LightState& lights, Colouring colouring);

/// Floor that the subject may darken, or floor and backdrop far from it.
enum class Surround { touched, open };

/// Fragment shader of the floor and the backdrop.
std::string surround_fragment_shader(const RenderPlan& plan, const LightState& lights, Surround surround);

/// Transparent bodies, drawn over what lies behind them: reflection, glints and a rim, premultiplied with opacity.
std::string clear_vertex_shader();
std::string clear_fragment_shader(const RenderPlan& plan, const LightState& lights);

} // namespace wry::render
