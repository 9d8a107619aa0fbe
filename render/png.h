#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "render/image.h"
#include "sim/base/result.h"

namespace wry::render {

/// One text chunk of a PNG: where a picture came from. Keys are 1-79 characters of Latin-1.
struct PngText {
  std::string key;
  std::string value; ///< UTF-8
};

enum class PngAlpha { drop, straight };

struct PngSettings {
  PngAlpha alpha = PngAlpha::drop;
  int compression = 1; ///< libdeflate's 1 (fast) to 12 (small)
};

/// The bytes of a PNG file: 8 bits, or 16 of a deep image, sRGB chunk, the texts as tEXt (ASCII) or iTXt. Errors:
/// bad_input for an empty image or a key that PNG does not allow, out_of_memory.
Result<std::vector<std::uint8_t>> encode_png(const Image& image, const std::vector<PngText>& texts,
                                             const PngSettings& settings = {});

/// encode_png, written aside and renamed. Errors: also cannot_write, io.
Status write_png(const std::filesystem::path& path, const Image& image, const std::vector<PngText>& texts,
                 const PngSettings& settings = {});

struct PngContents {
  Image image;
  std::vector<PngText> texts;
};

/// Reads and decodes a PNG wholly. Errors: missing_input, io (truncated or damaged).
Result<PngContents> read_png(const std::filesystem::path& path);

/// Ok when the file is there and every pixel and checksum decodes; the error says what is wrong with it.
Status png_is_whole(const std::filesystem::path& path);

} // namespace wry::render
