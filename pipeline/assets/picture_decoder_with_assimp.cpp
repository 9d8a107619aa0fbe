#include "pipeline/assets/materials.h"

#include <csetjmp>
#include <cstdio>
#include <cstring>

#include <jpeglib.h>
#include <png.h>

namespace wry::pipeline {

namespace {

constexpr unsigned SIDE_MAX = 8192;

Error too_large(unsigned width, unsigned height) {
  return make_error(ErrorCode::bad_input, "{} x {} pixels; at most {} a side", width, height, SIDE_MAX);
}

Result<render::Image> decode_png(const std::string& bytes) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()) == 0)
    return make_error(ErrorCode::bad_input, "not a whole PNG: {}", png.message);
  if (png.width < 1 || png.height < 1 || png.width > SIDE_MAX || png.height > SIDE_MAX) {
    png_image_free(&png);
    return too_large(png.width, png.height);
  }
  png.format = PNG_FORMAT_RGBA;
  render::Image image(static_cast<int>(png.width), static_cast<int>(png.height));
  if (png_image_finish_read(&png, nullptr, image.pixels.data(), 0, nullptr) == 0)
    return make_error(ErrorCode::bad_input, "not a whole PNG: {}", png.message);
  return image;
}

/// libjpeg leaves by a jump when a file is damaged.
struct JpegFailure {
  jpeg_error_mgr manager;
  std::jmp_buf back;
  char message[JMSG_LENGTH_MAX];
};

void on_jpeg_error(j_common_ptr jpeg) {
  auto* failure = reinterpret_cast<JpegFailure*>(jpeg->err);
  jpeg->err->format_message(jpeg, failure->message);
  std::longjmp(failure->back, 1);
}

/// Everything that a jump may skip the end of lives with the caller.
bool read_jpeg(jpeg_decompress_struct& jpeg, JpegFailure& failure, const std::string& bytes, render::Image& image,
               std::vector<unsigned char>& row) {
  if (setjmp(failure.back) != 0)
    return false;
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&jpeg, TRUE);
  if (jpeg.image_width > SIDE_MAX || jpeg.image_height > SIDE_MAX) {
    std::snprintf(failure.message, sizeof failure.message, "%u x %u pixels; at most %u a side", jpeg.image_width,
                  jpeg.image_height, SIDE_MAX);
    return false;
  }
  jpeg.out_color_space = JCS_RGB;
  jpeg_start_decompress(&jpeg);
  image = render::Image(static_cast<int>(jpeg.output_width), static_cast<int>(jpeg.output_height));
  row.resize(std::size_t{jpeg.output_width} * 3);
  while (jpeg.output_scanline < jpeg.output_height) {
    std::uint8_t* out = image.at(0, static_cast<int>(jpeg.output_scanline));
    unsigned char* rows[] = {row.data()};
    jpeg_read_scanlines(&jpeg, rows, 1);
    for (std::size_t x = 0; x < jpeg.output_width; ++x) {
      std::memcpy(out + 4 * x, row.data() + 3 * x, 3);
      out[4 * x + 3] = 255;
    }
  }
  jpeg_finish_decompress(&jpeg);
  return true;
}

Result<render::Image> decode_jpeg(const std::string& bytes) {
  jpeg_decompress_struct jpeg{};
  JpegFailure failure{};
  jpeg.err = jpeg_std_error(&failure.manager);
  failure.manager.error_exit = on_jpeg_error;
  failure.manager.emit_message = [](j_common_ptr, int) {};
  render::Image image;
  std::vector<unsigned char> row;
  const bool whole = read_jpeg(jpeg, failure, bytes, image, row);
  jpeg_destroy_decompress(&jpeg);
  if (!whole)
    return make_error(ErrorCode::bad_input, "not a whole JPEG: {}", failure.message);
  return image;
}

/// Targa has no magic number: a header that makes sense is taken for one. Pixels of 24 or 32 bits, plain or in runs.
bool is_targa(const std::string& bytes) {
  if (bytes.size() < 18)
    return false;
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  return byte(1) == 0 && (byte(2) == 2 || byte(2) == 10) && (byte(16) == 24 || byte(16) == 32);
}

Result<render::Image> decode_targa(const std::string& bytes) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  const unsigned width = byte(12) + 256u * byte(13);
  const unsigned height = byte(14) + 256u * byte(15);
  if (width < 1 || height < 1 || width > SIDE_MAX || height > SIDE_MAX)
    return too_large(width, height);
  const std::size_t step = byte(16) / 8u;
  const bool in_runs = byte(2) == 10;
  const bool from_top = (byte(17) & 0x20u) != 0;
  render::Image image(static_cast<int>(width), static_cast<int>(height));
  std::size_t at = 18u + byte(0);
  std::size_t left = 0; // pixels of the current packet
  bool is_run = false;
  for (std::size_t i = 0; i < std::size_t{width} * height; ++i) {
    if (in_runs && left == 0) {
      if (at >= bytes.size())
        return make_error(ErrorCode::bad_input, "the Targa picture ends early");
      is_run = (byte(at) & 0x80u) != 0;
      left = (byte(at) & 0x7fu) + 1u;
      ++at;
    }
    if (at + step > bytes.size())
      return make_error(ErrorCode::bad_input, "the Targa picture ends early");
    const std::size_t row = i / width;
    std::uint8_t* out = image.at(static_cast<int>(i % width), static_cast<int>(from_top ? row : height - 1 - row));
    out[0] = byte(at + 2);
    out[1] = byte(at + 1);
    out[2] = byte(at);
    out[3] = step == 4 ? byte(at + 3) : std::uint8_t{255};
    left -= in_runs ? 1 : 0;
    if (!in_runs || !is_run || left == 0)
      at += step;
  }
  return image;
}

} // namespace

Result<render::Image> decode_picture(const std::string& bytes) {
  if (bytes.compare(0, 4, "\x89PNG") == 0)
    return decode_png(bytes);
  if (bytes.compare(0, 2, "\xff\xd8") == 0)
    return decode_jpeg(bytes);
  if (is_targa(bytes))
    return decode_targa(bytes);
  return make_error(ErrorCode::bad_input, "neither a PNG, a JPEG nor a Targa of 24 or 32 bits");
}

} // namespace wry::pipeline
