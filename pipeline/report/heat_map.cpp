#include "pipeline/report/heat_map.h"

#include <algorithm>
#include <array>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/report/plot_canvas.h"
#include "render/png.h"

namespace wry::pipeline {

namespace {

constexpr double CELL_HEIGHT = 30.0, TEXT_SIZE = 11.0;

struct MarkStyle {
  MapMark mark;
  const char* word;
  render::DisplayColour colour;
};

constexpr std::array<MarkStyle, 5> STYLES = {{
    {MapMark::holds, "holds", {0.16f, 0.50f, 0.62f}},
    {MapMark::holds_with_smaller_steps, "holds with smaller steps", {0.91f, 0.78f, 0.35f}},
    {MapMark::refuses, "refuses, and says why", {0.62f, 0.64f, 0.67f}},
    {MapMark::unfinished, "not done in its time", {0.56f, 0.48f, 0.70f}},
    {MapMark::fails, "fails", {0.72f, 0.15f, 0.20f}},
}};

const MarkStyle* style_of(MapMark mark) {
  const auto found = std::find_if(STYLES.begin(), STYLES.end(), [&](const MarkStyle& s) { return s.mark == mark; });
  return found == STYLES.end() ? nullptr : &*found;
}

struct Layout {
  double left = 0.0, top = 76.0, cell_width = 64.0;
  int width = 0, height = 0;
};

Layout layout_of(const MapPlot& map) {
  Layout layout;
  for (const std::string& row : map.rows)
    layout.left = std::max(layout.left, canvas_text_width(row, TEXT_SIZE) + 22.0);
  for (const std::string& column : map.columns)
    layout.cell_width = std::max(layout.cell_width, canvas_text_width(column, TEXT_SIZE) + 10.0);
  for (const std::vector<MapCell>& row : map.cells) {
    for (const MapCell& cell : row)
      layout.cell_width = std::max(layout.cell_width, canvas_text_width(cell.text, TEXT_SIZE) + 10.0);
  }
  layout.width = static_cast<int>(layout.left + layout.cell_width * static_cast<double>(map.columns.size()) + 16.0);
  layout.width = std::max({layout.width, 640, static_cast<int>(canvas_text_width(map.title, 15.0)) + 32});
  layout.height = static_cast<int>(layout.top + CELL_HEIGHT * static_cast<double>(map.rows.size()) + 14.0);
  return layout;
}

void draw_key(PlotCanvas& canvas) {
  double x = 16.0;
  for (const MarkStyle& style : STYLES) {
    canvas.rectangle({x, 33.0}, 13.0, 13.0, style.colour);
    canvas.text({x + 19.0, 44.0}, style.word, TEXT_SIZE, Anchor::start, Ink::muted);
    x += 19.0 + canvas_text_width(style.word, TEXT_SIZE) + 14.0;
  }
}

void draw(const MapPlot& map, const Layout& layout, PlotCanvas& canvas) {
  canvas.text({16.0, 22.0}, map.title, 15.0, Anchor::start, Ink::text);
  draw_key(canvas);
  const auto x_of = [&](std::size_t column) { return layout.left + layout.cell_width * static_cast<double>(column); };
  for (std::size_t column = 0; column < map.columns.size(); ++column)
    canvas.text({x_of(column) + 0.5 * layout.cell_width, layout.top - 8.0}, map.columns[column], TEXT_SIZE,
                Anchor::middle, Ink::muted);
  for (std::size_t row = 0; row < map.rows.size(); ++row) {
    const double y = layout.top + CELL_HEIGHT * static_cast<double>(row);
    canvas.text({layout.left - 8.0, y + 0.5 * CELL_HEIGHT + 4.0}, map.rows[row], TEXT_SIZE, Anchor::end, Ink::text);
    for (std::size_t column = 0; row < map.cells.size() && column < map.cells[row].size(); ++column) {
      const MapCell& cell = map.cells[row][column];
      const MarkStyle* style = style_of(cell.mark);
      if (style == nullptr)
        continue;
      canvas.rectangle({x_of(column) + 1.0, y + 1.0}, layout.cell_width - 2.0, CELL_HEIGHT - 2.0, style->colour);
      canvas.text_on({x_of(column) + 0.5 * layout.cell_width, y + 0.5 * CELL_HEIGHT + 4.0}, cell.text, TEXT_SIZE,
                     style->colour);
    }
  }
}

} // namespace

std::string map_svg(const MapPlot& map, PlotTheme theme) {
  const Layout layout = layout_of(map);
  SvgCanvas canvas(layout.width, layout.height, theme, map.title);
  draw(map, layout, canvas);
  return canvas.finish();
}

render::Image map_image(const MapPlot& map, PlotTheme theme) {
  const Layout layout = layout_of(map);
  ImageCanvas canvas(layout.width, layout.height, 2.0, theme);
  draw(map, layout, canvas);
  return canvas.finish();
}

Status write_map(const std::string& path_without_extension, const MapPlot& map) {
  if (Status status = write_file_atomically(path_without_extension + ".svg", map_svg(map)); !status)
    return status;
  return render::write_png(path_without_extension + ".png", map_image(map), {{"Title", map.title}});
}

} // namespace wry::pipeline
