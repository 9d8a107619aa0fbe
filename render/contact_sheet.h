#pragma once

#include <string>
#include <vector>

#include "render/image.h"
#include "sim/base/result.h"

namespace wry::render {

struct SheetEntry {
  Image image;
  std::string label;
};

struct SheetSettings {
  int columns = 0;      ///< 0: as square as the count allows
  int cell_width = 480; ///< [pixels] 64 ... 4096
  /// Words over each column and before each row; empty: none. With heads of columns there are as many columns.
  std::vector<std::string> column_heads = {}, row_heads = {};
};

/// One picture of many, each shrunk to its cell with its label beneath, row by row. All entries take the aspect of the
/// first; others are fitted inside. Errors: bad_input for no entries, an empty image, or a sheet beyond 16384 pixels.
Result<Image> make_contact_sheet(const std::vector<SheetEntry>& entries, const SheetSettings& settings = {});

/// The image at another, smaller or equal size: the mean of the light (not of the encoded values) that falls on each
/// pixel.
Image shrunk(const Image& image, int width, int height);

} // namespace wry::render
