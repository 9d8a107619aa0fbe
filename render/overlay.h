#pragma once

#include <string>
#include <vector>

#include "render/image.h"
#include "render/view.h"

namespace wry::render {

/// Burns lines of text into the lower left corner, the last line lowest, at a size that reads on the whole picture.
void draw_slate(Image& image, const std::vector<std::string>& lines);

/// Draws the colour bar of a heat view along the right edge: title, unit, and ticks at round values of its range.
void draw_colour_bar(Image& image, const HeatStyle& style);

/// Round values within [low, high], about `wanted` of them, in rising order; at least the two ends when none is round.
std::vector<double> round_ticks(double low, double high, int wanted);

} // namespace wry::render
