#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "render/passes/touched_rect.h"

namespace wry::render {

/// Which parts of a still picture change from sub-frame to sub-frame: tiles that the subject covers or shades. In the
/// others floor and backdrop are evenly lit in all sub-frames, so that once is enough.
class PictureTiles {
public:
  static constexpr int SIDE = 16; ///< [pixels]

  explicit PictureTiles(const ImageSize& size);

  /// Begins a picture: no tile has been drawn.
  void clear();
  /// Tiles of `rect` change whatever comes.
  void keep_drawing(const PixelRect& rect);
  /// Tiles where the key light has blockers change, and those next to them. `occlusion`: the occlusion layer, row after
  /// row from the bottom: visibility, distance and share of the blockers, 1.
  void take_blockers(std::span<const std::array<std::uint8_t, 4>> occlusion);
  /// Marks tiles where something stands before the sky or the key light, and those next to them. `mean`: the occlusion
  /// at half the size, as half floats, row after row from the bottom: visibility, distance times share, share, any.
  void take_enclosed(std::span<const std::array<std::uint16_t, 4>> mean, const ImageSize& half_size);
  std::vector<PixelRect> enclosed() const;

  /// Takes what a sub-frame sees. `depth`: row after row from the bottom, 0 where nothing of the subject is.
  void take_depths(std::span<const float> depth);

  /// The subject is in them in this sub-frame, and the key light may be blocked there.
  std::vector<PixelRect> shaded_subject() const;
  /// The subject is in them, and all of the key light arrives.
  std::vector<PixelRect> open_subject() const;
  /// They show floor that the subject may shade.
  std::vector<PixelRect> shaded_floor() const;
  /// They show floor without shadow beside the subject.
  std::vector<PixelRect> open_floor() const;
  /// They hold the subject for the first time; what went before is owed.
  std::vector<PixelRect> newly_busy() const;
  /// No sub-frame so far had anything in them that changes.
  std::vector<PixelRect> still() const;

private:
  enum Mark : std::uint8_t {
    SUBJECT = 1,    ///< now
    FLOOR = 2,      ///< now
    SHADED = 4,     ///< the key light may be blocked
    BUSY = 8,       ///< drawn in each sub-frame
    NEWLY_BUSY = 16 ///< since this sub-frame
  };
  /// The tiles that have all of `wanted` and none of `unwanted`, in as few rectangles as rows and columns allow.
  std::vector<PixelRect> rects(unsigned wanted, unsigned unwanted) const;

  std::size_t place_of(int row, int column) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(m_columns) + static_cast<std::size_t>(column);
  }

  ImageSize m_size;
  int m_columns;
  int m_rows;
  std::vector<std::uint8_t> m_marks;
};

} // namespace wry::render
