#pragma once

#include <string>

#include "render/passes/light_state.h"
#include "render/view.h"

namespace wry::render {

/// Fragment shader that shades the subject's pixels; the number of lights and which one casts are fixed in it.
std::string subject_fragment_shader(const LightState& lights, Colouring colouring);

/// Floor that the subject may darken, or floor and backdrop far from it.
enum class Surround { touched, open };

/// Fragment shader of the floor and the backdrop.
std::string surround_fragment_shader(const LightState& lights, Surround surround);

} // namespace wry::render
