#include "render/overlay.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "render/text/draw_text.h"

namespace wry::render {
namespace {

/// 16 pixels of capital height at 1080 lines, never below what can be read.
TextStyle style_for(const Image& image) {
  TextStyle style;
  style.capital_height = std::max(16.0 * image.height / 1080.0, 7.0);
  return style;
}

} // namespace

void draw_slate(Image& image, const std::vector<std::string>& lines) {
  const TextStyle style = style_for(image);
  const double line_height = 1.9 * style.capital_height;
  double baseline = image.height - 1.6 * style.capital_height;
  for (std::size_t i = lines.size(); i-- > 0; baseline -= line_height)
    draw_text(image, 1.6 * style.capital_height, baseline, lines[i], style);
}

std::vector<double> round_ticks(double low, double high, int wanted) {
  const double rough = (high - low) / std::max(wanted, 1);
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * power;
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough * 0.999) {
      step = factor * power;
      break;
    }
  }
  std::vector<double> ticks;
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1.0)
    ticks.push_back(k == 0.0 ? 0.0 : k * step);
  if (ticks.size() < 2)
    ticks = {low, high};
  return ticks;
}

void draw_colour_bar(Image& image, const HeatStyle& heat) {
  const TextStyle style = style_for(image);
  const double em = style.capital_height;
  const int bar_width = static_cast<int>(1.5 * em);
  const int bar_height = image.height / 2;
  const int top = (image.height - bar_height) / 2;
  const std::vector<double> ticks = round_ticks(heat.low, heat.high, 6);
  double label_width = 0.0;
  for (const double tick : ticks)
    label_width = std::max(label_width, text_width(fmt::format("{:.4g}", tick), style));
  const int left = image.width - static_cast<int>(label_width + 4.2 * em);
  fill_rectangle(image, left - 2, top - 2, bar_width + 4, bar_height + 4, {0.05f, 0.05f, 0.05f}, 1.f);
  for (int row = 0; row < bar_height; ++row)
    fill_rectangle(image, left, top + row, bar_width, 1, heat_colour(1.0 - (row + 0.5) / bar_height), 1.f);
  for (const double tick : ticks) {
    const double y = top + bar_height * (1.0 - (tick - heat.low) / (heat.high - heat.low));
    fill_rectangle(image, left + bar_width, static_cast<int>(std::lround(y)) - 1, static_cast<int>(0.5 * em), 2,
                   style.colour, 1.f);
    draw_text(image, left + bar_width + 0.9 * em, y + 0.5 * em, fmt::format("{:.4g}", tick), style);
  }
  const std::string name = heat.title.empty() ? heat.channel : heat.title;
  const std::string title = heat.unit.empty() ? name : fmt::format("{} [{}]", name, heat.unit);
  draw_text(image, image.width - text_width(title, style) - 1.2 * em, top - 1.6 * em, title, style);
}

} // namespace wry::render
