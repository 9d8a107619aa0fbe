#include <algorithm>
#include <cmath>

#include "pipeline/report/plot_canvas.h"
#include "render/text/draw_text.h"

namespace wry::pipeline {

namespace {

constexpr double DASH = 6.0, GAP = 4.0;    ///< [pixels of the plot]
constexpr double MOST_DASHED_LENGTH = 1e5; ///< [pixels of the plot]

} // namespace

ImageCanvas::ImageCanvas(int width, int height, double zoom, PlotTheme theme)
    : m_image(static_cast<int>(width * zoom), static_cast<int>(height * zoom))
    , m_zoom(zoom)
    , m_theme(theme) {
  render::fill_rectangle(m_image, 0, 0, m_image.width, m_image.height, ink_colour(theme, Ink::paper, 0), 1.f);
}

void ImageCanvas::blend(int x, int y, const render::DisplayColour& colour, double opacity) {
  if (x < 0 || y < 0 || x >= m_image.width || y >= m_image.height || opacity <= 0.0)
    return;
  render::fill_rectangle(m_image, x, y, 1, 1, colour, static_cast<float>(std::min(opacity, 1.0)));
}

void ImageCanvas::stroke(CanvasPoint from, CanvasPoint to, const Pen& pen) {
  const double half = std::max(0.5 * pen.width * m_zoom, 0.5);
  const render::DisplayColour colour = ink_colour(m_theme, pen.ink, pen.series);
  const CanvasPoint a{from.x * m_zoom, from.y * m_zoom}, b{to.x * m_zoom, to.y * m_zoom};
  const double dx = b.x - a.x, dy = b.y - a.y, square = std::max(dx * dx + dy * dy, 1e-12);
  const double reach = half + 1.0;
  const int y0 = std::max(static_cast<int>(std::min(a.y, b.y) - reach), 0);
  const int y1 = std::min(static_cast<int>(std::max(a.y, b.y) + reach), m_image.height - 1);
  const int x0 = std::max(static_cast<int>(std::min(a.x, b.x) - reach), 0);
  const int x1 = std::min(static_cast<int>(std::max(a.x, b.x) + reach), m_image.width - 1);
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const double px = x + 0.5 - a.x, py = y + 0.5 - a.y;
      const double t = std::clamp((px * dx + py * dy) / square, 0.0, 1.0);
      blend(x, y, colour, half + 0.5 - std::hypot(px - t * dx, py - t * dy));
    }
  }
}

void ImageCanvas::polyline(const std::vector<CanvasPoint>& points, const Pen& pen) {
  double done = 0.0; // length of the segments before
  for (std::size_t i = 1; i < points.size(); ++i) {
    const CanvasPoint from = points[i - 1], to = points[i];
    const double length = std::hypot(to.x - from.x, to.y - from.y);
    const auto between = [&](double s) {
      const double part = length > 0.0 ? std::clamp((s - done) / length, 0.0, 1.0) : 0.0;
      return CanvasPoint{from.x + (to.x - from.x) * part, from.y + (to.y - from.y) * part};
    };
    if (!pen.dashed || !(length < MOST_DASHED_LENGTH)) {
      stroke(from, to, pen);
      continue;
    }
    // Dash k covers [k period, k period + DASH] of the whole line.
    constexpr double PERIOD = DASH + GAP;
    for (double k = std::floor(done / PERIOD); k * PERIOD < done + length; ++k) {
      if (k * PERIOD + DASH > done)
        stroke(between(k * PERIOD), between(k * PERIOD + DASH), pen);
    }
    done += length;
  }
}

void ImageCanvas::mark(CanvasPoint at, std::size_t series) {
  const render::DisplayColour colour = ink_colour(m_theme, Ink::series, series);
  const double cx = at.x * m_zoom, cy = at.y * m_zoom;
  const int reach = static_cast<int>(6.0 * m_zoom);
  for (int y = static_cast<int>(cy) - reach; y <= static_cast<int>(cy) + reach; ++y) {
    for (int x = static_cast<int>(cx) - reach; x <= static_cast<int>(cx) + reach; ++x) {
      const double px = (x + 0.5 - cx) / m_zoom, py = (y + 0.5 - cy) / m_zoom;
      double outside = std::hypot(px, py) - 3.6; // [pixels of the plot] beyond the edge of the shape
      if (series % 4 == 1)
        outside = std::max(std::abs(px), std::abs(py)) - 3.2;
      else if (series % 4 == 2)
        outside = std::max(py - 2.6, std::abs(px) * 0.864 - py * 0.504 - 2.32);
      else if (series % 4 == 3)
        outside = (std::abs(px) + std::abs(py) - 4.6) * 0.7071;
      blend(x, y, colour, 0.5 - outside * m_zoom);
    }
  }
}

void ImageCanvas::rectangle(CanvasPoint corner, double width, double height, const render::DisplayColour& colour) {
  const auto pixel = [&](double value) { return static_cast<int>(std::lround(value * m_zoom)); };
  render::fill_rectangle(m_image, pixel(corner.x), pixel(corner.y), pixel(corner.x + width) - pixel(corner.x),
                         pixel(corner.y + height) - pixel(corner.y), colour, 1.f);
}

void ImageCanvas::text(CanvasPoint at, std::string_view words, double size, Anchor anchor, Ink ink) {
  render::TextStyle style;
  style.capital_height = 0.72 * size * m_zoom;
  style.colour = ink_colour(m_theme, ink, 0);
  style.halo = 0.f;
  const double width = render::text_width(words, style);
  const double shift = anchor == Anchor::start ? 0.0 : anchor == Anchor::middle ? 0.5 * width : width;
  render::draw_text(m_image, at.x * m_zoom - shift, at.y * m_zoom, words, style);
}

void ImageCanvas::text_on(CanvasPoint at, std::string_view words, double size, const render::DisplayColour& beneath) {
  render::TextStyle style;
  style.capital_height = 0.72 * size * m_zoom;
  const bool light = 0.3f * beneath[0] + 0.6f * beneath[1] + 0.1f * beneath[2] > 0.5f;
  style.colour = light ? render::DisplayColour{0.07f, 0.07f, 0.07f} : render::DisplayColour{1.f, 1.f, 1.f};
  style.halo = 0.f;
  render::draw_text(m_image, at.x * m_zoom - 0.5 * render::text_width(words, style), at.y * m_zoom, words, style);
}

} // namespace wry::pipeline
