#pragma once

#include <string>
#include <vector>

#include "render/image.h"
#include "sim/base/result.h"

namespace wry::pipeline {

enum class PlotScale { linear, logarithmic };

/// How a series is drawn. Every series has a shape of its own besides its colour, for colour-blind eyes and grey print.
enum class PlotMark { line, points, line_and_points, dashed };

/// One curve or cloud. Values that are not finite, or not positive on a logarithmic axis, are left out and break a
/// line.
struct PlotSeries {
  std::string label; ///< in the legend; empty: not listed
  std::vector<double> x, y;
  PlotMark mark = PlotMark::line;
  std::vector<std::string> point_labels; ///< beside points; empty, or one per point ("" for none)
};

/// A plot as it is asked for.
struct Plot {
  std::string title;
  std::string x_label, y_label; ///< with unit: "time [s]"
  PlotScale x_scale = PlotScale::linear, y_scale = PlotScale::linear;
  std::vector<PlotSeries> series;
  int width = 760, height = 420; ///< [pixels]
};

/// Which colours: light and dark are fixed; automatic follows the reader's browser (SVG only).
enum class PlotTheme { automatic, light, dark };

/// The plot as a self-contained SVG document; it can stand in a page as it is.
std::string plot_svg(const Plot& plot, PlotTheme theme = PlotTheme::automatic);

/// The plot as a picture of twice its size, for where no SVG is shown. `automatic` is light.
render::Image plot_image(const Plot& plot, PlotTheme theme = PlotTheme::light);

/// Both: `path` with .svg and with .png. Errors: cannot_write, io.
Status write_plot(const std::string& path_without_extension, const Plot& plot);

/// Round values within [low, high] for an axis, at most about `wanted` of them (log: powers of ten, or 1-2-5 where
/// few).
std::vector<double> axis_ticks(double low, double high, PlotScale scale, int wanted);

} // namespace wry::pipeline
