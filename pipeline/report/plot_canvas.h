#pragma once

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pipeline/report/plot.h"
#include "render/color_map.h"
#include "render/image.h"

namespace wry::pipeline {

/// What a stroke is for; the theme gives it its colour.
enum class Ink { paper, text, muted, grid, series };

/// Colours of a theme; `automatic` counts as light.
render::DisplayColour ink_colour(PlotTheme theme, Ink ink, std::size_t series);
inline constexpr std::size_t SERIES_COLOURS = 8;

struct Pen {
  Ink ink = Ink::text;
  std::size_t series = 0; ///< whose colour, when the ink is series
  double width = 1.0;     ///< [pixels]
  bool dashed = false;
};

enum class Anchor { start, middle, end };

struct CanvasPoint {
  double x = 0.0, y = 0.0; ///< [pixels] from the left, from the top
};

/// What plots are drawn on: an SVG document or a picture.
class PlotCanvas {
public:
  virtual ~PlotCanvas() = default;
  virtual void polyline(const std::vector<CanvasPoint>& points, const Pen& pen) = 0;
  /// A filled mark; its shape goes with the series.
  virtual void mark(CanvasPoint at, std::size_t series) = 0;
  virtual void rectangle(CanvasPoint corner, double width, double height, const render::DisplayColour& colour) = 0;
  /// One line of text; `at` is on its baseline. `size` is the font's size [pixels].
  virtual void text(CanvasPoint at, std::string_view words, double size, Anchor anchor, Ink ink) = 0;
  /// Text over a filled rectangle, dark or light by that colour.
  virtual void text_on(CanvasPoint at, std::string_view words, double size, const render::DisplayColour& beneath) = 0;
};

/// How wide a canvas draws text, with room for other fonts [pixels].
double canvas_text_width(std::string_view words, double size);

/// Draws onto an SVG document.
class SvgCanvas final : public PlotCanvas {
public:
  SvgCanvas(int width, int height, PlotTheme theme, std::string_view title);
  void polyline(const std::vector<CanvasPoint>& points, const Pen& pen) override;
  void mark(CanvasPoint at, std::size_t series) override;
  void rectangle(CanvasPoint corner, double width, double height, const render::DisplayColour& colour) override;
  void text(CanvasPoint at, std::string_view words, double size, Anchor anchor, Ink ink) override;
  void text_on(CanvasPoint at, std::string_view words, double size, const render::DisplayColour& beneath) override;
  std::string finish();

private:
  std::string m_svg;
};

/// Draws onto a picture, `zoom` pixels for each of the plot's.
class ImageCanvas final : public PlotCanvas {
public:
  ImageCanvas(int width, int height, double zoom, PlotTheme theme);
  void polyline(const std::vector<CanvasPoint>& points, const Pen& pen) override;
  void mark(CanvasPoint at, std::size_t series) override;
  void rectangle(CanvasPoint corner, double width, double height, const render::DisplayColour& colour) override;
  void text(CanvasPoint at, std::string_view words, double size, Anchor anchor, Ink ink) override;
  void text_on(CanvasPoint at, std::string_view words, double size, const render::DisplayColour& beneath) override;
  render::Image finish() { return std::move(m_image); }

private:
  void stroke(CanvasPoint from, CanvasPoint to, const Pen& pen);
  void blend(int x, int y, const render::DisplayColour& colour, double opacity);
  render::Image m_image;
  double m_zoom;
  PlotTheme m_theme;
};

/// Text as XML and HTML want it.
std::string escape_markup(std::string_view text);

} // namespace wry::pipeline
