#pragma once

#include <array>
#include <span>

namespace wry::render {

/// sRGB-encoded red, green, blue in [0, 1].
using DisplayColour = std::array<float, 3>;

/// Evenly spaced colours of viridis (van der Walt and Smith 2015, CC0): perceptually even, safe for colour-blind eyes.
std::span<const DisplayColour> heat_colours();

/// The colour at t in [0, 1], straight between its neighbours.
DisplayColour heat_colour(double t);

} // namespace wry::render
