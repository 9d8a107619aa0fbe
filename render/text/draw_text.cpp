#include "render/text/draw_text.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "render/text/font.h"

namespace wry::render {
namespace {

constexpr double STROKE_WIDTH = 0.95; // in units of the font

/// Distance of every pixel of a window to the nearest stroke, up to `reach`.
class DistanceWindow {
public:
  DistanceWindow(int x, int y, int width, int height, double reach)
      : m_x(x)
      , m_y(y)
      , m_width(width)
      , m_height(height)
      , m_reach(reach)
      , m_distances(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), static_cast<float>(reach)) {}

  void add(const std::array<double, 2>& a, const std::array<double, 2>& b) {
    const int x0 = std::max(static_cast<int>(std::floor(std::min(a[0], b[0]) - m_reach)), m_x);
    const int x1 = std::min(static_cast<int>(std::ceil(std::max(a[0], b[0]) + m_reach)), m_x + m_width - 1);
    const int y0 = std::max(static_cast<int>(std::floor(std::min(a[1], b[1]) - m_reach)), m_y);
    const int y1 = std::min(static_cast<int>(std::ceil(std::max(a[1], b[1]) + m_reach)), m_y + m_height - 1);
    const double dx = b[0] - a[0];
    const double dy = b[1] - a[1];
    const double square = std::max(dx * dx + dy * dy, 1e-12);
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const double px = x + 0.5 - a[0];
        const double py = y + 0.5 - a[1];
        const double t = std::clamp((px * dx + py * dy) / square, 0.0, 1.0);
        float& distance = m_distances[index(x, y)];
        distance = std::min(distance, static_cast<float>(std::hypot(px - t * dx, py - t * dy)));
      }
    }
  }

  float at(int x, int y) const { return m_distances[index(x, y)]; }

private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y - m_y) * static_cast<std::size_t>(m_width) + static_cast<std::size_t>(x - m_x);
  }
  int m_x, m_y, m_width, m_height;
  double m_reach;
  std::vector<float> m_distances;
};

void blend(std::uint8_t* pixel, const DisplayColour& colour, float opacity) {
  for (std::size_t c = 0; c < 3; ++c) {
    const float mixed = static_cast<float>(pixel[c]) + opacity * (255.f * colour[c] - static_cast<float>(pixel[c]));
    pixel[c] = static_cast<std::uint8_t>(std::clamp(mixed + 0.5f, 0.f, 255.f));
  }
  const float alpha = static_cast<float>(pixel[3]);
  pixel[3] = static_cast<std::uint8_t>(std::clamp(alpha + opacity * (255.f - alpha) + 0.5f, 0.f, 255.f));
}

} // namespace

double text_width(std::string_view utf8, const TextStyle& style) {
  double width = 0.0;
  for (const char32_t letter : letters_of(utf8))
    width += glyph(letter).advance;
  return width * style.capital_height / FONT_CAPITAL_HEIGHT;
}

void draw_text(Image& image, double x, double baseline, std::string_view utf8, const TextStyle& style) {
  const double unit = style.capital_height / FONT_CAPITAL_HEIGHT;
  const double half_width = std::max(0.5 * STROKE_WIDTH * unit, 0.55);
  const double halo_reach = half_width + std::max(1.2 * unit, 1.5);
  const int x0 = std::max(static_cast<int>(x - halo_reach) - 1, 0);
  const int x1 = std::min(static_cast<int>(x + text_width(utf8, style) + halo_reach) + 2, image.width);
  const int y0 = std::max(static_cast<int>(baseline - style.capital_height - halo_reach) - 1, 0);
  const int y1 = std::min(static_cast<int>(baseline + 2.0 * unit + halo_reach) + 2, image.height);
  if (x1 <= x0 || y1 <= y0)
    return;
  DistanceWindow window(x0, y0, x1 - x0, y1 - y0, halo_reach + 1.0);
  double pen = x;
  for (const char32_t letter : letters_of(utf8)) {
    const auto place = [&](const std::array<double, 2>& p) {
      return std::array<double, 2>{pen + unit * p[0], baseline - unit * p[1]};
    };
    for (const Stroke& stroke : glyph(letter).strokes)
      window.add(place(stroke.from), place(stroke.to));
    pen += unit * glyph(letter).advance;
  }
  for (int row = y0; row < y1; ++row) {
    for (int column = x0; column < x1; ++column) {
      const double distance = window.at(column, row);
      const double edge = std::clamp((halo_reach - distance) / (halo_reach - half_width), 0.0, 1.0);
      blend(image.at(column, row), {0.f, 0.f, 0.f}, style.halo * static_cast<float>(edge * edge));
      const double inside = std::clamp(half_width + 0.5 - distance, 0.0, 1.0);
      blend(image.at(column, row), style.colour, static_cast<float>(inside));
    }
  }
}

void fill_rectangle(Image& image, int x, int y, int width, int height, const DisplayColour& colour, float opacity) {
  for (int row = std::max(y, 0); row < std::min(y + height, image.height); ++row) {
    for (int column = std::max(x, 0); column < std::min(x + width, image.width); ++column)
      blend(image.at(column, row), colour, opacity);
  }
}

} // namespace wry::render
