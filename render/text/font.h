#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace wry::render {

/// A piece of a letter, in units of the font: baseline at 0, capitals 7 high, small letters 5, descenders to -2.
struct Stroke {
  std::array<double, 2> from{};
  std::array<double, 2> to{};
};

struct Glyph {
  std::vector<Stroke> strokes;
  double advance = 0.0; ///< to the next letter's origin
};

constexpr double FONT_CAPITAL_HEIGHT = 7.0;

/// The font's own drawing of a letter; a box for one that it lacks. Covers ASCII, the degree sign, micro and middle
/// dot.
const Glyph& glyph(char32_t letter);

/// The letters of UTF-8 text; bytes that are not UTF-8 become boxes.
std::u32string letters_of(std::string_view utf8);

} // namespace wry::render
