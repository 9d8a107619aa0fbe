#include "render/compare_images.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "render/color_map.h"
#include "render/overlay.h"
#include "render/text/draw_text.h"

namespace wry::render {
namespace {

Status check_sizes(const Image& a, const Image& b) {
  if (a.width == b.width && a.height == b.height && a.width > 0)
    return {};
  return make_error(ErrorCode::bad_input, "pictures of {} x {} and {} x {} pixels cannot be compared", a.width,
                    a.height, b.width, b.height);
}

} // namespace

Result<Image> split_images(const Image& left, const Image& right, const std::string& left_label,
                           const std::string& right_label, double place) {
  if (const Status good = check_sizes(left, right); !good.ok())
    return good.error();
  Image made = left;
  made.deep.clear();
  const int line = std::clamp(static_cast<int>(std::lround(place * left.width)), 0, left.width);
  for (int y = 0; y < left.height; ++y)
    std::copy_n(right.at(0, y) + 4 * line, static_cast<std::size_t>(left.width - line) * 4, made.at(0, y) + 4 * line);
  const int width = std::max(2, left.width / 960);
  fill_rectangle(made, line - width / 2, 0, width, left.height, {0.92f, 0.92f, 0.92f}, 0.9f);
  TextStyle style;
  style.capital_height = std::max(16.0 * left.height / 1080.0, 7.0);
  const double baseline = 2.6 * style.capital_height;
  draw_text(made, line - text_width(left_label, style) - 1.2 * style.capital_height, baseline, left_label, style);
  draw_text(made, line + 1.2 * style.capital_height, baseline, right_label, style);
  return made;
}

Result<ImageDifference> difference_of_images(const Image& a, const Image& b, double full) {
  if (const Status good = check_sizes(a, b); !good.ok())
    return good.error();
  ImageDifference found;
  found.map = Image(a.width, a.height);
  const double count = static_cast<double>(a.width) * a.height;
  for (std::size_t i = 0; i < a.pixels.size(); i += 4) {
    int apart = 0;
    for (std::size_t c = 0; c < 3; ++c)
      apart = std::max(apart, std::abs(static_cast<int>(a.pixels[i + c]) - static_cast<int>(b.pixels[i + c])));
    found.mean += apart / count;
    found.greatest = std::max(found.greatest, static_cast<double>(apart));
    found.pixels_apart += apart > 0 ? 1 : 0;
    const DisplayColour colour = heat_colour(apart / full);
    for (std::size_t c = 0; c < 3; ++c)
      found.map.pixels[i + c] = static_cast<std::uint8_t>(std::lround(255.f * colour[c]));
    found.map.pixels[i + 3] = 255;
  }
  HeatStyle bar;
  bar.low = 0.0;
  bar.high = full;
  bar.title = "difference";
  bar.unit = "of 255";
  draw_colour_bar(found.map, bar);
  return found;
}

} // namespace wry::render
