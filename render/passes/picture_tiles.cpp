#include "render/passes/picture_tiles.h"

#include <algorithm>
#include <cassert>

namespace wry::render {

PictureTiles::PictureTiles(const ImageSize& size)
    : m_size(size)
    , m_columns((size.width + SIDE - 1) / SIDE)
    , m_rows((size.height + SIDE - 1) / SIDE)
    , m_marks(static_cast<std::size_t>(m_columns) * static_cast<std::size_t>(m_rows), 0) {}

void PictureTiles::clear() {
  std::fill(m_marks.begin(), m_marks.end(), std::uint8_t{0});
}

void PictureTiles::keep_drawing(const PixelRect& rect) {
  if (rect.width <= 0 || rect.height <= 0)
    return;
  for (int row = std::max(rect.y / SIDE, 0); row <= std::min((rect.y + rect.height - 1) / SIDE, m_rows - 1); ++row) {
    for (int column = std::max(rect.x / SIDE, 0); column <= std::min((rect.x + rect.width - 1) / SIDE, m_columns - 1);
         ++column)
      m_marks[place_of(row, column)] |= SHADED | BUSY;
  }
}

void PictureTiles::take_blockers(std::span<const std::array<std::uint8_t, 4>> occlusion) {
  assert(occlusion.size() == static_cast<std::size_t>(m_size.width) * static_cast<std::size_t>(m_size.height));
  std::vector<std::uint8_t> blocked(m_marks.size(), 0);
  for (int y = 0; y < m_size.height; ++y) {
    const std::array<std::uint8_t, 4>* pixel =
        occlusion.data() + static_cast<std::ptrdiff_t>(y) * static_cast<std::ptrdiff_t>(m_size.width);
    std::uint8_t* tile = blocked.data() + static_cast<std::ptrdiff_t>(y / SIDE) * m_columns;
    for (int column = 0; column < m_columns; ++column) {
      std::uint8_t share = 0;
      for (int x = column * SIDE; x < std::min(column * SIDE + SIDE, m_size.width); ++x)
        share |= pixel[x][2];
      tile[column] |= share;
    }
  }
  // The search is coarse: what is next to a blocked tile may be at the edge of the same shadow.
  for (int row = 0; row < m_rows; ++row) {
    for (int column = 0; column < m_columns; ++column) {
      if (blocked[place_of(row, column)] != 0)
        keep_drawing({(column - 1) * SIDE, (row - 1) * SIDE, 3 * SIDE, 3 * SIDE});
    }
  }
}

void PictureTiles::take_enclosed(std::span<const std::array<std::uint16_t, 4>> mean, const ImageSize& half_size) {
  assert(mean.size() == static_cast<std::size_t>(half_size.width) * static_cast<std::size_t>(half_size.height));
  constexpr int HALF_SIDE = SIDE / 2;
  constexpr std::uint16_t OPEN = 0x3BFE; // .99902: rounds to all of 8 bits; half floats above 0 are ordered as integers
  std::vector<std::uint8_t> found(m_marks.size(), 0);
  for (int y = 0; y < half_size.height; ++y) {
    const std::array<std::uint16_t, 4>* row =
        mean.data() + static_cast<std::ptrdiff_t>(y) * static_cast<std::ptrdiff_t>(half_size.width);
    for (int x = 0; x < half_size.width; ++x) {
      const bool closed = row[x][0] < OPEN || row[x][0] >= 0x8000 || row[x][2] != 0;
      found[place_of(y / HALF_SIDE, x / HALF_SIDE)] |= static_cast<std::uint8_t>(closed);
    }
  }
  for (int tile_row = 0; tile_row < m_rows; ++tile_row) {
    for (int column = 0; column < m_columns; ++column) {
      if (found[place_of(tile_row, column)] != 0)
        keep_drawing({(column - 1) * SIDE, (tile_row - 1) * SIDE, 3 * SIDE, 3 * SIDE});
    }
  }
}

void PictureTiles::take_depths(std::span<const float> depth) {
  assert(depth.size() == static_cast<std::size_t>(m_size.width) * static_cast<std::size_t>(m_size.height));
  for (std::uint8_t& mark : m_marks)
    mark &= static_cast<std::uint8_t>(~(SUBJECT | FLOOR | NEWLY_BUSY));
  for (int y = 0; y < m_size.height; ++y) {
    const float* row = depth.data() + static_cast<std::ptrdiff_t>(y) * static_cast<std::ptrdiff_t>(m_size.width);
    std::uint8_t* tile = m_marks.data() + static_cast<std::ptrdiff_t>(y / SIDE) * m_columns;
    for (int column = 0; column < m_columns; ++column) {
      const int begin = column * SIDE;
      const int end = std::min(begin + SIDE, m_size.width);
      const auto there = static_cast<int>(std::count_if(row + begin, row + end, [](float d) { return d > 0.f; }));
      tile[column] |= static_cast<std::uint8_t>((there > 0 ? SUBJECT : 0) | (there < end - begin ? FLOOR : 0));
    }
  }
  for (std::uint8_t& mark : m_marks) {
    if ((mark & SUBJECT) != 0 && (mark & BUSY) == 0)
      mark |= BUSY | NEWLY_BUSY;
  }
}

std::vector<PixelRect> PictureTiles::enclosed() const {
  return rects(BUSY, 0);
}

std::vector<PixelRect> PictureTiles::shaded_subject() const {
  return rects(SUBJECT | SHADED, 0);
}

std::vector<PixelRect> PictureTiles::open_subject() const {
  return rects(SUBJECT, SHADED);
}

std::vector<PixelRect> PictureTiles::shaded_floor() const {
  return rects(FLOOR | BUSY | SHADED, 0);
}

std::vector<PixelRect> PictureTiles::open_floor() const {
  return rects(FLOOR | BUSY, SHADED);
}

std::vector<PixelRect> PictureTiles::newly_busy() const {
  return rects(NEWLY_BUSY, 0);
}

std::vector<PixelRect> PictureTiles::still() const {
  return rects(0, BUSY);
}

std::vector<PixelRect> PictureTiles::rects(unsigned wanted, unsigned unwanted) const {
  std::vector<PixelRect> open; // those that reach up to the row below, in tiles
  std::vector<PixelRect> done;
  for (int row = 0; row < m_rows; ++row) {
    std::vector<PixelRect> reaching;
    for (int begin = 0; begin < m_columns; ++begin) {
      const auto chosen = [&](int column) {
        const unsigned mark = m_marks[place_of(row, column)];
        return (mark & wanted) == wanted && (mark & unwanted) == 0;
      };
      int end = begin;
      while (end < m_columns && chosen(end))
        ++end;
      if (end == begin)
        continue;
      const auto below = std::find_if(open.begin(), open.end(), [&](const PixelRect& rect) {
        return rect.x == begin && rect.width == end - begin;
      });
      PixelRect rect{begin, row, end - begin, 1};
      if (below != open.end()) {
        rect.y = below->y;
        rect.height = row - rect.y + 1;
        open.erase(below);
      }
      reaching.push_back(rect);
      begin = end;
    }
    done.insert(done.end(), open.begin(), open.end());
    open = std::move(reaching);
  }
  done.insert(done.end(), open.begin(), open.end());
  for (PixelRect& rect : done) {
    rect = {SIDE * rect.x, SIDE * rect.y, SIDE * rect.width, SIDE * rect.height};
    rect.width = std::min(rect.width, m_size.width - rect.x);
    rect.height = std::min(rect.height, m_size.height - rect.y);
  }
  return done;
}

} // namespace wry::render
