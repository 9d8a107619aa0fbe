#include "pipeline/report/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/report/plot_canvas.h"
#include "render/png.h"

namespace wry::pipeline {

namespace {

using Colour = render::DisplayColour;

constexpr Colour rgb(int hex) {
  return {static_cast<float>(hex >> 16) / 255.f, static_cast<float>((hex >> 8) & 255) / 255.f,
          static_cast<float>(hex & 255) / 255.f};
}

constexpr std::array<Colour, 4> LIGHT_INKS = {rgb(0xffffff), rgb(0x1c2128), rgb(0x5a6470), rgb(0xe2e5e9)};
constexpr std::array<Colour, 4> DARK_INKS = {rgb(0x16191d), rgb(0xe8eaed), rgb(0x9aa4af), rgb(0x2e343b)};
constexpr std::array<Colour, SERIES_COLOURS> LIGHT_SERIES = {rgb(0x1f6fb4), rgb(0xd1571b), rgb(0x23844a),
                                                             rgb(0x8a4fb0), rgb(0xa87808), rgb(0xc2366b),
                                                             rgb(0x0b8686), rgb(0x4d5763)};
constexpr std::array<Colour, SERIES_COLOURS> DARK_SERIES = {rgb(0x6db3f2), rgb(0xf59b6a), rgb(0x6fcf8e), rgb(0xc39be6),
                                                            rgb(0xe5c158), rgb(0xf08bb0), rgb(0x5fd0d0), rgb(0xb0b8c4)};

constexpr double TITLE_SIZE = 15.0, LABEL_SIZE = 12.0, TICK_SIZE = 11.0;
constexpr double LEGEND_ROW = 17.0, LEGEND_MARK = 26.0;

bool shown(double value, PlotScale scale) {
  return std::isfinite(value) && (scale == PlotScale::linear || value > 0.0);
}

/// The extent of one axis and its way to pixels.
struct Axis {
  PlotScale scale = PlotScale::linear;
  double low = 0.0, high = 1.0;
  double from = 0.0, to = 1.0; ///< [pixels] of low and high

  double place(double value) const {
    const auto even = [&](double v) { return scale == PlotScale::logarithmic ? std::log10(v) : v; };
    return from + (to - from) * (even(value) - even(low)) / (even(high) - even(low));
  }
};

Axis fit_axis(const Plot& plot, PlotScale scale, std::vector<double> PlotSeries::*values) {
  Axis axis{scale, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const PlotSeries& series : plot.series) {
    for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
      if (!shown(series.x[i], plot.x_scale) || !shown(series.y[i], plot.y_scale))
        continue;
      axis.low = std::min(axis.low, (series.*values)[i]);
      axis.high = std::max(axis.high, (series.*values)[i]);
    }
  }
  if (!(axis.low <= axis.high)) {
    axis.low = scale == PlotScale::linear ? 0.0 : 0.1;
    axis.high = 1.0;
  } else if (scale == PlotScale::logarithmic) {
    const double margin = std::max(std::pow(axis.high / axis.low, 0.05), 1.12);
    axis.low /= margin;
    axis.high *= margin;
  } else {
    const double size = std::max({std::abs(axis.low), std::abs(axis.high), 1e-300});
    const double span = std::max(axis.high - axis.low, 1e-9 * size);
    const bool flat = axis.high - axis.low < 1e-9 * size;
    axis.low -= flat ? 0.5 * size : 0.04 * span;
    axis.high += flat ? 0.5 * size : 0.04 * span;
  }
  return axis;
}

std::string tick_label(double value) {
  if (value == 0.0)
    return "0";
  const double size = std::abs(value);
  return size >= 1e5 || size < 1e-3 ? fmt::format("{:.3g}", value) : fmt::format("{:.6g}", value);
}

/// Draws a plot onto a canvas.
class PlotDrawing {
public:
  PlotDrawing(const Plot& plot, PlotCanvas& canvas)
      : m_plot(plot)
      , m_canvas(canvas)
      , m_x(fit_axis(plot, plot.x_scale, &PlotSeries::x))
      , m_y(fit_axis(plot, plot.y_scale, &PlotSeries::y)) {
    arrange();
  }

  void draw() {
    m_canvas.text({m_left, 22.0}, m_plot.title, TITLE_SIZE, Anchor::start, Ink::text);
    m_canvas.text({m_left, m_top - 9.0}, m_plot.y_label, LABEL_SIZE, Anchor::start, Ink::muted);
    m_canvas.text({m_right, m_plot.height - 8.0}, m_plot.x_label, LABEL_SIZE, Anchor::end, Ink::muted);
    draw_grid();
    bool any = false;
    for (std::size_t i = 0; i < m_plot.series.size(); ++i)
      any = draw_series(m_plot.series[i], i) || any;
    if (!any)
      m_canvas.text({0.5 * (m_left + m_right), 0.5 * (m_top + m_bottom)}, "nothing to show", LABEL_SIZE, Anchor::middle,
                    Ink::muted);
    draw_legend();
  }

private:
  void arrange() {
    double widest_tick = 0.0, widest_label = 0.0;
    for (const double tick : axis_ticks(m_y.low, m_y.high, m_y.scale, 6))
      widest_tick = std::max(widest_tick, canvas_text_width(tick_label(tick), TICK_SIZE));
    for (const PlotSeries& series : m_plot.series) {
      if (!series.label.empty())
        widest_label = std::max(widest_label, canvas_text_width(series.label, LABEL_SIZE));
    }
    const double legend = widest_label > 0.0 ? widest_label + LEGEND_MARK + 18.0 : 16.0;
    m_left = widest_tick + 20.0;
    m_right = std::max(m_plot.width - std::min(legend, 0.45 * m_plot.width), m_left + 40.0);
    m_top = m_plot.title.empty() ? 30.0 : 52.0;
    m_bottom = std::max(m_plot.height - 44.0, m_top + 40.0);
    m_x.from = m_left;
    m_x.to = m_right;
    m_y.from = m_bottom;
    m_y.to = m_top;
  }

  void draw_grid() {
    const int columns = std::clamp(static_cast<int>((m_right - m_left) / 80.0), 2, 9);
    for (const double tick : axis_ticks(m_x.low, m_x.high, m_x.scale, columns)) {
      const double x = m_x.place(tick);
      m_canvas.polyline({{x, m_top}, {x, m_bottom}}, {Ink::grid, 0, 1.0, false});
      m_canvas.text({x, m_bottom + 16.0}, tick_label(tick), TICK_SIZE, Anchor::middle, Ink::muted);
    }
    for (const double tick : axis_ticks(m_y.low, m_y.high, m_y.scale, 6)) {
      const double y = m_y.place(tick);
      m_canvas.polyline({{m_left, y}, {m_right, y}}, {Ink::grid, 0, 1.0, false});
      m_canvas.text({m_left - 8.0, y + 4.0}, tick_label(tick), TICK_SIZE, Anchor::end, Ink::muted);
    }
    m_canvas.polyline({{m_left, m_top}, {m_left, m_bottom}, {m_right, m_bottom}}, {Ink::muted, 0, 1.0, false});
  }

  bool draw_series(const PlotSeries& series, std::size_t index) {
    const Pen pen{Ink::series, index, 2.0, series.mark == PlotMark::dashed};
    std::vector<CanvasPoint> run;
    bool any = false;
    const std::size_t count = std::min(series.x.size(), series.y.size());
    const bool dotted = series.mark == PlotMark::points || series.mark == PlotMark::line_and_points;
    for (std::size_t i = 0; i < count; ++i) {
      if (!shown(series.x[i], m_plot.x_scale) || !shown(series.y[i], m_plot.y_scale)) {
        finish_run(run, pen, series.mark);
        continue;
      }
      any = true;
      run.push_back({m_x.place(series.x[i]), m_y.place(series.y[i])});
      if (dotted)
        m_canvas.mark(run.back(), index);
      if (i < series.point_labels.size() && !series.point_labels[i].empty())
        label_point(run.back(), series.point_labels[i]);
    }
    finish_run(run, pen, series.mark);
    return any;
  }

  void finish_run(std::vector<CanvasPoint>& run, const Pen& pen, PlotMark mark) {
    if (mark != PlotMark::points)
      m_canvas.polyline(run, pen);
    run.clear();
  }

  void label_point(CanvasPoint at, const std::string& label) {
    const bool left = at.x + 8.0 + canvas_text_width(label, TICK_SIZE) > m_plot.width;
    m_canvas.text({at.x + (left ? -7.0 : 7.0), at.y - 5.0}, label, TICK_SIZE, left ? Anchor::end : Anchor::start,
                  Ink::text);
  }

  void draw_legend() {
    double y = m_top + 8.0;
    for (std::size_t i = 0; i < m_plot.series.size(); ++i) {
      const PlotSeries& series = m_plot.series[i];
      if (series.label.empty())
        continue;
      const double x = m_right + 12.0;
      if (series.mark != PlotMark::points)
        m_canvas.polyline({{x, y - 4.0}, {x + LEGEND_MARK - 6.0, y - 4.0}},
                          {Ink::series, i, 2.0, series.mark == PlotMark::dashed});
      if (series.mark == PlotMark::points || series.mark == PlotMark::line_and_points)
        m_canvas.mark({x + 0.5 * (LEGEND_MARK - 6.0), y - 4.0}, i);
      m_canvas.text({x + LEGEND_MARK, y}, series.label, LABEL_SIZE, Anchor::start, Ink::text);
      y += LEGEND_ROW;
    }
  }

  const Plot& m_plot;
  PlotCanvas& m_canvas;
  Axis m_x, m_y;
  double m_left = 0.0, m_right = 0.0, m_top = 0.0, m_bottom = 0.0;
};

std::vector<double> linear_ticks(double low, double high, int wanted) {
  const double raw = (high - low) / std::max(wanted, 1);
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  const double step = power * (raw <= power * 1.0001   ? 1.0
                               : raw <= 2.0001 * power ? 2.0
                               : raw <= 5.0001 * power ? 5.0
                                                       : 10.0);
  std::vector<double> ticks;
  for (double index = std::ceil(low / step - 1e-9); index * step <= high + 1e-9 * step; ++index)
    ticks.push_back(index * step == 0.0 ? 0.0 : index * step);
  return ticks;
}

std::vector<double> logarithmic_ticks(double low, double high, int wanted) {
  const int first = static_cast<int>(std::floor(std::log10(low)));
  const int last = static_cast<int>(std::ceil(std::log10(high)));
  const int stride = std::max(1, (last - first) / std::max(wanted, 1));
  std::vector<double> ticks;
  const bool few = std::log10(high / low) < 2.0;
  for (int exponent = first; exponent <= last; exponent += stride) {
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double tick = digit * std::pow(10.0, exponent);
      if ((digit == 1.0 || few) && tick >= low && tick <= high)
        ticks.push_back(tick);
    }
  }
  return ticks.size() >= 2 ? ticks : linear_ticks(low, high, wanted);
}

} // namespace

render::DisplayColour ink_colour(PlotTheme theme, Ink ink, std::size_t series) {
  const bool dark = theme == PlotTheme::dark;
  if (ink == Ink::series)
    return (dark ? DARK_SERIES : LIGHT_SERIES)[series % SERIES_COLOURS];
  return (dark ? DARK_INKS : LIGHT_INKS)[static_cast<std::size_t>(ink)];
}

std::vector<double> axis_ticks(double low, double high, PlotScale scale, int wanted) {
  return scale == PlotScale::linear ? linear_ticks(low, high, wanted) : logarithmic_ticks(low, high, wanted);
}

std::string plot_svg(const Plot& plot, PlotTheme theme) {
  SvgCanvas canvas(plot.width, plot.height, theme, plot.title);
  PlotDrawing(plot, canvas).draw();
  return canvas.finish();
}

render::Image plot_image(const Plot& plot, PlotTheme theme) {
  ImageCanvas canvas(plot.width, plot.height, 2.0, theme);
  PlotDrawing(plot, canvas).draw();
  return canvas.finish();
}

Status write_plot(const std::string& path_without_extension, const Plot& plot) {
  if (Status status = write_file_atomically(path_without_extension + ".svg", plot_svg(plot)); !status)
    return status;
  return render::write_png(path_without_extension + ".png", plot_image(plot), {{"Title", plot.title}});
}

} // namespace wry::pipeline
