#include "render/png.h"

#include <algorithm>
#include <array>
#include <memory>
#include <string_view>

#include <libdeflate.h>

#include "render/write_file.h"

namespace wry::render {
namespace {

using Bytes = std::vector<std::uint8_t>;

void append_u32(Bytes& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8)
    bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

void append_chunk(Bytes& file, std::string_view type, std::span<const std::uint8_t> data) {
  append_u32(file, static_cast<std::uint32_t>(data.size()));
  const std::size_t checked_from = file.size();
  file.insert(file.end(), type.begin(), type.end());
  file.insert(file.end(), data.begin(), data.end());
  append_u32(file, libdeflate_crc32(0, file.data() + checked_from, file.size() - checked_from));
}

bool is_key(std::string_view key) {
  const auto printable = [](char c) {
    return static_cast<unsigned char>(c) >= 32 && static_cast<unsigned char>(c) < 127;
  };
  return !key.empty() && key.size() <= 79 && key.front() != ' ' && key.back() != ' ' &&
         std::all_of(key.begin(), key.end(), printable);
}

void append_text(Bytes& file, const PngText& text) {
  const bool ascii =
      std::all_of(text.value.begin(), text.value.end(), [](char c) { return static_cast<unsigned char>(c) < 128; });
  Bytes data(text.key.begin(), text.key.end());
  data.push_back(0);
  if (!ascii)
    data.insert(data.end(), 4, 0); // iTXt: not compressed, method 0, no language, no translated key
  data.insert(data.end(), text.value.begin(), text.value.end());
  append_chunk(file, ascii ? "tEXt" : "iTXt", data);
}

/// Rows with PNG's SUB filter (each byte minus the one a pixel to the left), the filter's number in front of each.
Bytes filtered_rows(const Image& image, int channels) {
  const std::size_t width = static_cast<std::size_t>(image.width);
  const std::size_t step = static_cast<std::size_t>(channels);
  Bytes rows(static_cast<std::size_t>(image.height) * (1 + width * step));
  std::uint8_t* out = rows.data();
  for (int y = 0; y < image.height; ++y) {
    *out++ = 1;
    std::array<std::uint8_t, 4> left{};
    const std::uint8_t* in = image.at(0, y);
    for (std::size_t x = 0; x < width; ++x, in += 4) {
      for (std::size_t c = 0; c < step; ++c) {
        *out++ = static_cast<std::uint8_t>(in[c] - left[c]);
        left[c] = in[c];
      }
    }
  }
  return rows;
}

/// The same for 16 bits: high byte first.
Bytes filtered_deep_rows(const Image& image, int channels) {
  const std::size_t width = static_cast<std::size_t>(image.width);
  const std::size_t step = static_cast<std::size_t>(channels);
  Bytes rows(static_cast<std::size_t>(image.height) * (1 + 2 * width * step));
  std::uint8_t* out = rows.data();
  for (std::size_t y = 0; y < static_cast<std::size_t>(image.height); ++y) {
    *out++ = 1;
    std::array<std::uint8_t, 8> left{};
    const std::uint16_t* in = image.deep.data() + 4 * width * y;
    for (std::size_t x = 0; x < width; ++x, in += 4) {
      for (std::size_t c = 0; c < step; ++c) {
        for (std::size_t half = 0; half < 2; ++half) {
          const auto byte = static_cast<std::uint8_t>(in[c] >> (half == 0 ? 8 : 0));
          *out++ = static_cast<std::uint8_t>(byte - left[2 * c + half]);
          left[2 * c + half] = byte;
        }
      }
    }
  }
  return rows;
}

Result<Bytes> compressed(const Bytes& rows, int level) {
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
      libdeflate_alloc_compressor(std::clamp(level, 1, 12)), &libdeflate_free_compressor);
  if (!compressor)
    return make_error(ErrorCode::out_of_memory, "no memory to compress a PNG");
  Bytes data(libdeflate_zlib_compress_bound(compressor.get(), rows.size()));
  data.resize(libdeflate_zlib_compress(compressor.get(), rows.data(), rows.size(), data.data(), data.size()));
  if (data.empty())
    return make_error(ErrorCode::io, "the {} bytes of a picture could not be compressed", rows.size());
  return data;
}

} // namespace

Result<Bytes> encode_png(const Image& image, const std::vector<PngText>& texts, const PngSettings& settings) {
  if (image.width <= 0 || image.height <= 0)
    return make_error(ErrorCode::bad_input, "a picture of {} x {} pixels cannot be a PNG", image.width, image.height);
  const bool with_alpha = settings.alpha == PngAlpha::straight;
  Bytes file = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  Bytes header;
  append_u32(header, static_cast<std::uint32_t>(image.width));
  append_u32(header, static_cast<std::uint32_t>(image.height));
  const std::array<std::uint8_t, 5> kind = {static_cast<std::uint8_t>(image.deep.empty() ? 8 : 16),
                                            static_cast<std::uint8_t>(with_alpha ? 6 : 2), 0, 0, 0};
  header.insert(header.end(), kind.begin(), kind.end());
  append_chunk(file, "IHDR", header);
  append_chunk(file, "sRGB", std::array<std::uint8_t, 1>{0});
  for (const PngText& text : texts) {
    if (!is_key(text.key))
      return make_error(ErrorCode::bad_input, "\"{}\" cannot be a PNG text key: 1 to 79 printable ASCII characters",
                        text.key);
    append_text(file, text);
  }
  const Result<Bytes> data = compressed(image.deep.empty() ? filtered_rows(image, with_alpha ? 4 : 3)
                                                           : filtered_deep_rows(image, with_alpha ? 4 : 3),
                                        settings.compression);
  if (!data.ok())
    return data.error();
  append_chunk(file, "IDAT", *data);
  append_chunk(file, "IEND", {});
  return file;
}

Status write_png(const std::filesystem::path& path, const Image& image, const std::vector<PngText>& texts,
                 const PngSettings& settings) {
  const Result<Bytes> bytes = encode_png(image, texts, settings);
  if (!bytes.ok())
    return Error{bytes.error().code, path.string() + ": " + bytes.error().message};
  return write_file_atomically(path, *bytes);
}

} // namespace wry::render
