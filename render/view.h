#pragma once

#include <optional>
#include <string>
#include <vector>

namespace wry::render {

/// Which quantity a heat view shows, and over which range. The range is the sequence's, not the frame's, so that a
/// colour means the same on every picture.
struct HeatStyle {
  std::string channel; ///< of vertices or tets, e.g. "speed"
  int component = -1;  ///< -1: the Euclidean norm of all components
  double low = 0.0;    ///< value of the first colour
  double high = 1.0;   ///< value of the last colour; greater than low
  std::string title;   ///< beside the bar; empty: the channel's name
  std::string unit;    ///< e.g. "m/s"
};

enum class Colouring { look, clay, heat };
enum class Wire { none, overlay };
enum class Tone { filmic, plain }; ///< plain: the sRGB curve alone, so that map colours are those of the bar

/// What is drawn upon the bodies, which are of clay then.
enum class Signs { none, directors, fibres, contacts };

/// One way to draw a frame. Views are data: a new one is a line in a table, here or in a shot.
struct View {
  std::string name;
  Colouring colouring = Colouring::look;
  Wire wire = Wire::none;
  Signs signs = Signs::none;
  Tone tone = Tone::filmic;
  std::optional<HeatStyle> heat; ///< with Colouring::heat
};

/// beauty, clay, wire, directors, fibres and contacts.
std::vector<View> standard_views();

/// The heat view of a channel, named "heat-<channel>".
View heat_view(const HeatStyle& style);

} // namespace wry::render
