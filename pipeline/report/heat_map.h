#pragma once

#include <string>
#include <vector>

#include "render/image.h"
#include "sim/base/result.h"

#include "pipeline/report/plot.h"

namespace wry::pipeline {

/// What a cell of a map stands for; each has its colour and its sign, so that the map reads in grey too.
enum class MapMark { none, holds, holds_with_smaller_steps, refuses, unfinished, fails };

struct MapCell {
  MapMark mark = MapMark::none;
  std::string text; ///< a few letters: "3.2x"
};

/// A table of coloured cells with names of rows and columns: the stability map.
struct MapPlot {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::string> rows;
  std::vector<std::vector<MapCell>> cells; ///< rows x columns; short rows are filled with none
};

std::string map_svg(const MapPlot& map, PlotTheme theme = PlotTheme::automatic);
render::Image map_image(const MapPlot& map, PlotTheme theme = PlotTheme::light);
/// Both: `path` with .svg and with .png. Errors: cannot_write, io.
Status write_map(const std::string& path_without_extension, const MapPlot& map);

} // namespace wry::pipeline
