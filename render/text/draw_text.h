#pragma once

#include <string_view>

#include "render/color_map.h"
#include "render/image.h"

namespace wry::render {

struct TextStyle {
  double capital_height = 16.0; ///< [pixels]; 10 is still readable
  DisplayColour colour = {0.94f, 0.94f, 0.94f};
  float halo = 0.6f; ///< 0 ... 1: darkness of the edge that keeps letters readable over anything
};

/// How far the text reaches to the right [pixels].
double text_width(std::string_view utf8, const TextStyle& style);

/// Draws one line, antialiased, with its origin at x [pixels from the left] on the baseline y [pixels from the top].
/// What falls outside the picture is cut off.
void draw_text(Image& image, double x, double baseline, std::string_view utf8, const TextStyle& style);

/// A filled rectangle, blended by `opacity`. Cut off at the picture's edges.
void fill_rectangle(Image& image, int x, int y, int width, int height, const DisplayColour& colour, float opacity);

} // namespace wry::render
