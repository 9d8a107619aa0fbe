#include "render/contact_sheet.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/text/draw_text.h"

namespace wry::render {
namespace {

constexpr int SIDE_MAX = 16384;

std::array<float, 256> decoding_table() {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double v = static_cast<double>(i) / 255.0;
    table[i] = static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
  }
  return table;
}

std::uint8_t encoded(double linear) {
  const double v = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::clamp(std::lround(255.0 * v), 0L, 255L));
}

struct Span {
  int first = 0;
  std::vector<double> weights; ///< of consecutive source pixels, sum 1
};

/// Which source pixels each of `to` target pixels covers, and by how much.
std::vector<Span> spans(int from, int to) {
  std::vector<Span> made(static_cast<std::size_t>(to));
  const double scale = static_cast<double>(from) / to;
  for (int i = 0; i < to; ++i) {
    Span& span = made[static_cast<std::size_t>(i)];
    const double low = i * scale;
    const double high = (i + 1) * scale;
    span.first = static_cast<int>(low);
    for (int k = span.first; k < std::min(static_cast<int>(std::ceil(high - 1e-9)), from); ++k)
      span.weights.push_back((std::min(high, k + 1.0) - std::max(low, static_cast<double>(k))) / scale);
  }
  return made;
}

/// Where the parts of a sheet lie [pixels].
struct Layout {
  int columns = 1, rows = 1;
  int cell_width = 0, cell_height = 0, gap = 0, label_height = 0;
  int left = 0, top = 0; ///< what the heads of rows and columns take
  TextStyle label, head;

  int width() const { return left + columns * (cell_width + gap) + gap; }
  int height() const { return top + rows * (cell_height + label_height + gap) + gap; }
  int x_of(int column) const { return left + gap + column * (cell_width + gap); }
  int y_of(int row) const { return top + gap + row * (cell_height + label_height + gap); }
};

Layout lay_out(const std::vector<SheetEntry>& entries, const SheetSettings& settings) {
  Layout layout;
  const int count = static_cast<int>(entries.size());
  const int asked = settings.column_heads.empty() ? settings.columns : static_cast<int>(settings.column_heads.size());
  layout.columns =
      asked > 0 ? std::min(asked, count) : static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count))));
  layout.rows = (count + layout.columns - 1) / layout.columns;
  layout.cell_width = std::clamp(settings.cell_width, 64, 4096);
  layout.cell_height = std::max(1, static_cast<int>(std::lround(static_cast<double>(layout.cell_width) *
                                                                entries[0].image.height / entries[0].image.width)));
  layout.label.capital_height = std::max(0.026 * layout.cell_width, 7.0);
  layout.label.halo = 0.f;
  layout.head = layout.label;
  layout.head.capital_height = std::max(0.042 * layout.cell_width, 9.0);
  layout.gap = std::max(layout.cell_width / 60, 4);
  layout.label_height = static_cast<int>(2.4 * layout.label.capital_height);
  if (!settings.column_heads.empty())
    layout.top = static_cast<int>(2.2 * layout.head.capital_height);
  for (const std::string& head : settings.row_heads)
    layout.left = std::max(layout.left, 2 * layout.gap + static_cast<int>(text_width(head, layout.head)));
  return layout;
}

/// Each over the middle of its column or beside the middle of its row.
void draw_heads(Image& sheet, const Layout& layout, const SheetSettings& settings) {
  for (std::size_t i = 0; i < settings.column_heads.size() && static_cast<int>(i) < layout.columns; ++i) {
    const double middle = layout.x_of(static_cast<int>(i)) + 0.5 * layout.cell_width;
    draw_text(sheet, middle - 0.5 * text_width(settings.column_heads[i], layout.head),
              layout.gap + 1.5 * layout.head.capital_height, settings.column_heads[i], layout.head);
  }
  for (std::size_t i = 0; i < settings.row_heads.size() && static_cast<int>(i) < layout.rows; ++i) {
    const double middle = layout.y_of(static_cast<int>(i)) + 0.5 * layout.cell_height;
    draw_text(sheet, layout.left - text_width(settings.row_heads[i], layout.head),
              middle + 0.5 * layout.head.capital_height, settings.row_heads[i], layout.head);
  }
}

void draw_entry(Image& sheet, const Layout& layout, const SheetEntry& entry, int left, int top) {
  const double scale = std::min({1.0, static_cast<double>(layout.cell_width) / entry.image.width,
                                 static_cast<double>(layout.cell_height) / entry.image.height});
  const Image small = shrunk(entry.image, std::max(1, static_cast<int>(std::lround(scale * entry.image.width))),
                             std::max(1, static_cast<int>(std::lround(scale * entry.image.height))));
  for (int y = 0; y < small.height; ++y)
    std::copy_n(
        small.at(0, y), static_cast<std::size_t>(small.width) * 4,
        sheet.at(left + (layout.cell_width - small.width) / 2, top + (layout.cell_height - small.height) / 2 + y));
  draw_text(sheet, left, top + layout.cell_height + 1.6 * layout.label.capital_height, entry.label, layout.label);
}

} // namespace

Image shrunk(const Image& image, int width, int height) {
  static const std::array<float, 256> decoded = decoding_table();
  const std::vector<Span> columns = spans(image.width, width);
  const std::vector<Span> rows = spans(image.height, height);
  Image small(width, height);
  for (int y = 0; y < height; ++y) {
    const Span& row = rows[static_cast<std::size_t>(y)];
    for (int x = 0; x < width; ++x) {
      const Span& column = columns[static_cast<std::size_t>(x)];
      std::array<double, 4> sum{};
      for (std::size_t j = 0; j < row.weights.size(); ++j) {
        for (std::size_t i = 0; i < column.weights.size(); ++i) {
          const std::uint8_t* pixel = image.at(column.first + static_cast<int>(i), row.first + static_cast<int>(j));
          const double weight = row.weights[j] * column.weights[i];
          for (std::size_t c = 0; c < 3; ++c)
            sum[c] += weight * static_cast<double>(decoded[pixel[c]]);
          sum[3] += weight * pixel[3];
        }
      }
      for (std::size_t c = 0; c < 3; ++c)
        small.at(x, y)[c] = encoded(sum[c]);
      small.at(x, y)[3] = static_cast<std::uint8_t>(std::lround(sum[3]));
    }
  }
  return small;
}

Result<Image> make_contact_sheet(const std::vector<SheetEntry>& entries, const SheetSettings& settings) {
  if (entries.empty())
    return make_error(ErrorCode::bad_input, "a contact sheet of no pictures");
  for (const SheetEntry& entry : entries) {
    if (entry.image.width <= 0 || entry.image.height <= 0)
      return make_error(ErrorCode::bad_input, "contact sheet: picture \"{}\" is empty", entry.label);
  }
  const Layout layout = lay_out(entries, settings);
  const int width = layout.width(), height = layout.height();
  if (width > SIDE_MAX || height > SIDE_MAX)
    return make_error(ErrorCode::bad_input, "a contact sheet of {} x {} pixels; at most {} on a side: fewer or smaller",
                      width, height, SIDE_MAX);
  Image sheet(width, height);
  fill_rectangle(sheet, 0, 0, width, height, {0.11f, 0.11f, 0.115f}, 1.f);
  draw_heads(sheet, layout, settings);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const int at = static_cast<int>(i);
    draw_entry(sheet, layout, entries[i], layout.x_of(at % layout.columns), layout.y_of(at / layout.columns));
  }
  return sheet;
}

} // namespace wry::render
