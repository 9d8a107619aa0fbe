#pragma once

#include <string>

#include "render/passes/light_state.h"
#include "render/view.h"

namespace wry::render {

/// Whether any look has a layer of lacquer or glaze: without, its light is not computed.
enum class Coats { none, some };

/// Where the key light may be blocked; or where it is not, though the sky may be.
enum class KeyLight { shaded, open };

/// Fragment shader that shades the subject's pixels; the number of lights and which one casts are fixed in it.
std::string subject_fragment_shader(const RenderPlan& plan, const LightState& lights, Colouring colouring, Coats coats,
                                    KeyLight key);

/// Fragment shader of the floor, and of the backdrop where the key light is open.
std::string surround_fragment_shader(const RenderPlan& plan, const LightState& lights, KeyLight key);

/// Transparent bodies, drawn over what lies behind them: reflection, glints and a rim, premultiplied with opacity.
std::string clear_vertex_shader();
std::string clear_fragment_shader(const RenderPlan& plan, const LightState& lights);

} // namespace wry::render
