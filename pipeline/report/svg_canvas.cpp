#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "pipeline/report/plot_canvas.h"
#include "render/text/draw_text.h"

namespace wry::pipeline {

namespace {

std::string hex(const render::DisplayColour& colour) {
  const auto byte = [](float value) { return static_cast<int>(std::lround(255.f * std::clamp(value, 0.f, 1.f))); };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(colour[0]), byte(colour[1]), byte(colour[2]));
}

std::string variables(PlotTheme theme) {
  std::string text = fmt::format("--paper:{};--text:{};--muted:{};--grid:{}", hex(ink_colour(theme, Ink::paper, 0)),
                                 hex(ink_colour(theme, Ink::text, 0)), hex(ink_colour(theme, Ink::muted, 0)),
                                 hex(ink_colour(theme, Ink::grid, 0)));
  for (std::size_t i = 0; i < SERIES_COLOURS; ++i)
    text += fmt::format(";--s{}:{}", i, hex(ink_colour(theme, Ink::series, i)));
  return text;
}

std::string variable(Ink ink, std::size_t series) {
  switch (ink) {
  case Ink::paper:
    return "var(--paper)";
  case Ink::text:
    return "var(--text)";
  case Ink::muted:
    return "var(--muted)";
  case Ink::grid:
    return "var(--grid)";
  case Ink::series:
    break;
  }
  return fmt::format("var(--s{})", series % SERIES_COLOURS);
}

const char* anchor_name(Anchor anchor) {
  return anchor == Anchor::start ? "start" : anchor == Anchor::middle ? "middle" : "end";
}

} // namespace

std::string escape_markup(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '"')
      escaped += "&quot;";
    else if (c == '\'')
      escaped += "&#39;";
    else if (static_cast<unsigned char>(c) >= 0x20 || c == '\n' || c == '\t')
      escaped += c;
  }
  return escaped;
}

double canvas_text_width(std::string_view words, double size) {
  render::TextStyle style;
  style.capital_height = 0.72 * size;
  return std::max(render::text_width(words, style), 0.56 * size * static_cast<double>(words.size()));
}

SvgCanvas::SvgCanvas(int width, int height, PlotTheme theme, std::string_view title) {
  const PlotTheme first = theme == PlotTheme::dark ? PlotTheme::dark : PlotTheme::light;
  m_svg = fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plot\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
                      "height=\"{1}\" role=\"img\" aria-label=\"{2}\">\n<style>.plot{{{3};font-family:system-ui,"
                      "'DejaVu Sans',sans-serif;max-width:100%;height:auto}}",
                      width, height, escape_markup(title), variables(first));
  if (theme == PlotTheme::automatic)
    m_svg += fmt::format("@media(prefers-color-scheme:dark){{.plot{{{}}}}}", variables(PlotTheme::dark));
  m_svg += fmt::format("</style>\n<rect width=\"{}\" height=\"{}\" fill=\"var(--paper)\"/>\n", width, height);
}

void SvgCanvas::polyline(const std::vector<CanvasPoint>& points, const Pen& pen) {
  if (points.size() < 2)
    return;
  m_svg += "<polyline fill=\"none\" points=\"";
  for (const CanvasPoint& point : points)
    m_svg += fmt::format("{:.2f},{:.2f} ", point.x, point.y);
  m_svg.pop_back();
  m_svg += fmt::format("\" stroke=\"{}\" stroke-width=\"{:g}\" stroke-linejoin=\"round\"{}/>\n",
                       variable(pen.ink, pen.series), pen.width, pen.dashed ? " stroke-dasharray=\"6 4\"" : "");
}

void SvgCanvas::mark(CanvasPoint at, std::size_t series) {
  const std::string fill = variable(Ink::series, series);
  switch (series % 4) {
  case 0:
    m_svg += fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"3.6\" fill=\"{}\"/>\n", at.x, at.y, fill);
    return;
  case 1:
    m_svg += fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"6.4\" height=\"6.4\" fill=\"{}\"/>\n", at.x - 3.2,
                         at.y - 3.2, fill);
    return;
  case 2:
    m_svg += fmt::format("<path d=\"M{:.2f} {:.2f}l4.2 7.2h-8.4z\" fill=\"{}\"/>\n", at.x, at.y - 4.6, fill);
    return;
  default:
    m_svg +=
        fmt::format("<path d=\"M{:.2f} {:.2f}l4.6 4.6l-4.6 4.6l-4.6 -4.6z\" fill=\"{}\"/>\n", at.x, at.y - 4.6, fill);
  }
}

void SvgCanvas::rectangle(CanvasPoint corner, double width, double height, const render::DisplayColour& colour) {
  m_svg += fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\"/>\n", corner.x,
                       corner.y, width, height, hex(colour));
}

void SvgCanvas::text(CanvasPoint at, std::string_view words, double size, Anchor anchor, Ink ink) {
  m_svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"{:g}\" text-anchor=\"{}\" fill=\"{}\">{}</text>\n",
                       at.x, at.y, size, anchor_name(anchor), variable(ink, 0), escape_markup(words));
}

void SvgCanvas::text_on(CanvasPoint at, std::string_view words, double size, const render::DisplayColour& beneath) {
  const bool light = 0.3f * beneath[0] + 0.6f * beneath[1] + 0.1f * beneath[2] > 0.5f;
  m_svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"{:g}\" text-anchor=\"middle\" fill=\"{}\">{}"
                       "</text>\n",
                       at.x, at.y, size, light ? "#111111" : "#ffffff", escape_markup(words));
}

std::string SvgCanvas::finish() {
  return m_svg + "</svg>\n";
}

} // namespace wry::pipeline
