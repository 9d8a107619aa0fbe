#include "render/png.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include <png.h>

namespace wry::render {
namespace {

struct Reader {
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::string message = "damaged";

  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }

  static void on_error(png_structp png, png_const_charp text) {
    static_cast<Reader*>(png_get_error_ptr(png))->message = text;
    png_longjmp(png, 1);
  }
  static void on_warning(png_structp, png_const_charp) {}
};

/// libpng leaves by longjmp: nothing with a destructor may be made in here after setjmp.
bool decode(Reader& reader, std::FILE* file, PngContents& contents, std::vector<png_bytep>& rows) {
  if (setjmp(png_jmpbuf(reader.png)) != 0)
    return false;
  png_init_io(reader.png, file);
  png_set_crc_action(reader.png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
  png_read_info(reader.png, reader.info);
  png_set_expand(reader.png);
  png_set_strip_16(reader.png);
  png_set_gray_to_rgb(reader.png);
  png_set_add_alpha(reader.png, 0xff, PNG_FILLER_AFTER);
  png_set_interlace_handling(reader.png);
  png_read_update_info(reader.png, reader.info);
  contents.image = Image(static_cast<int>(png_get_image_width(reader.png, reader.info)),
                         static_cast<int>(png_get_image_height(reader.png, reader.info)));
  rows.resize(static_cast<std::size_t>(contents.image.height));
  for (int y = 0; y < contents.image.height; ++y)
    rows[static_cast<std::size_t>(y)] = contents.image.at(0, y);
  png_read_image(reader.png, rows.data());
  png_read_end(reader.png, reader.info);
  return true;
}

void take_texts(const Reader& reader, PngContents& contents) {
  png_textp texts = nullptr;
  int count = 0;
  png_get_text(reader.png, reader.info, &texts, &count);
  for (int i = 0; i < count; ++i)
    contents.texts.push_back({texts[i].key, texts[i].text != nullptr ? texts[i].text : ""});
}

} // namespace

Result<PngContents> read_png(const std::filesystem::path& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file)
    return make_error(errno == ENOENT ? ErrorCode::missing_input : ErrorCode::io, "{}: cannot be read: {}",
                      path.string(), std::strerror(errno));
  Reader reader;
  reader.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader, &Reader::on_error, &Reader::on_warning);
  reader.info = reader.png != nullptr ? png_create_info_struct(reader.png) : nullptr;
  if (reader.info == nullptr)
    return make_error(ErrorCode::out_of_memory, "{}: no memory to read it", path.string());
  PngContents contents;
  std::vector<png_bytep> rows;
  if (!decode(reader, file.get(), contents, rows))
    return make_error(ErrorCode::io, "{}: not a whole PNG: {}", path.string(), reader.message);
  take_texts(reader, contents);
  return contents;
}

Status png_is_whole(const std::filesystem::path& path) {
  const Result<PngContents> contents = read_png(path);
  if (!contents.ok())
    return contents.error();
  return {};
}

} // namespace wry::render
