#include "render/environment.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>

#include "render/exr.h"

namespace wry::render {
namespace {

constexpr int SIDE_MAX = 16384;

Error damaged(const std::filesystem::path& path, const char* what) {
  return make_error(ErrorCode::bad_input, "{}: damaged Radiance picture: {}", path.string(), what);
}

/// A scan line of four planes, each in runs (Ward 1991); false when the bytes end or run over.
bool read_runs(const std::string& bytes, std::size_t& at, int width, std::vector<std::uint8_t>& line) {
  for (int plane = 0; plane < 4; ++plane) {
    int x = 0;
    while (x < width) {
      if (at >= bytes.size())
        return false;
      const int code = static_cast<unsigned char>(bytes[at++]);
      const bool is_run = code > 128;
      const int count = is_run ? code - 128 : code;
      const std::size_t needed = is_run ? 1 : static_cast<std::size_t>(count);
      if (count == 0 || x + count > width || at + needed > bytes.size())
        return false;
      for (int i = 0; i < count; ++i)
        line[static_cast<std::size_t>(4 * (x + i) + plane)] =
            static_cast<std::uint8_t>(bytes[at + (is_run ? 0 : static_cast<std::size_t>(i))]);
      at += needed;
      x += count;
    }
  }
  return true;
}

void append_light(const std::vector<std::uint8_t>& line, LinearImage& image) {
  for (std::size_t i = 0; i + 3 < line.size(); i += 4) {
    const float scale = line[i + 3] == 0 ? 0.f : std::ldexp(1.f, static_cast<int>(line[i + 3]) - 136);
    for (std::size_t c = 0; c < 3; ++c)
      image.pixels.push_back(static_cast<float>(line[i + c]) * scale);
    image.pixels.push_back(1.f);
  }
}

Result<LinearImage> read_radiance(const std::filesystem::path& path, const std::string& bytes) {
  const std::size_t header = bytes.find("\n\n");
  if (header == std::string::npos)
    return damaged(path, "its header does not end");
  const std::size_t line_end = bytes.find('\n', header + 2);
  int width = 0;
  int height = 0;
  if (line_end == std::string::npos ||
      std::sscanf(bytes.substr(header + 2, line_end - header - 2).c_str(), "-Y %d +X %d", &height, &width) != 2)
    return damaged(path, "no size of the form -Y height +X width");
  if (width < 8 || height < 1 || width > SIDE_MAX || height > SIDE_MAX)
    return damaged(path, "its size is out of range");
  LinearImage image{width, height, {}};
  image.pixels.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4);
  std::size_t at = line_end + 1;
  std::vector<std::uint8_t> line(static_cast<std::size_t>(width) * 4);
  for (int y = 0; y < height; ++y) {
    if (at + 4 > bytes.size())
      return damaged(path, "it ends early");
    const bool in_runs = bytes[at] == 2 && bytes[at + 1] == 2;
    if (in_runs) {
      at += 4;
      if (!read_runs(bytes, at, width, line))
        return damaged(path, "a run goes over its line");
    } else {
      if (at + line.size() > bytes.size())
        return damaged(path, "it ends early");
      std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), line.size(), line.begin());
      at += line.size();
    }
    append_light(line, image);
  }
  return image;
}

} // namespace

Result<LinearImage> read_light_image(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    return make_error(ErrorCode::missing_input, "{}: there is no such file, or it cannot be opened", path.string());
  const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (bytes.rfind("#?", 0) == 0)
    return read_radiance(path, bytes);
  if (bytes.rfind("\x76\x2f\x31\x01", 0) == 0)
    return read_exr_light(path);
  return make_error(ErrorCode::bad_input, "{}: neither a Radiance .hdr nor an OpenEXR picture", path.string());
}

} // namespace wry::render
