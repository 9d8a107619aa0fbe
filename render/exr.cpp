#include "render/exr.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <exception>
#include <unistd.h>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>

namespace wry::render {
namespace {

namespace imf = OPENEXR_IMF_NAMESPACE;

constexpr std::int64_t SIDE_MAX = 16384;

imf::PixelType pixel_type(ExrChannel::Type type) {
  switch (type) {
  case ExrChannel::Type::half_float:
    return imf::HALF;
  case ExrChannel::Type::integer:
    return imf::UINT;
  default:
    return imf::FLOAT;
  }
}

/// The values as the file keeps them.
std::vector<char> stored(const ExrChannel& channel) {
  const std::size_t width = channel.type == ExrChannel::Type::half_float ? 2 : 4;
  std::vector<char> bytes(channel.values.size() * width);
  for (std::size_t i = 0; i < channel.values.size(); ++i) {
    if (channel.type == ExrChannel::Type::half_float) {
      const half value(std::min(std::max(channel.values[i], -65504.f), 65504.f));
      std::memcpy(bytes.data() + 2 * i, &value, 2);
    } else if (channel.type == ExrChannel::Type::integer) {
      const auto value = static_cast<std::uint32_t>(channel.values[i]);
      std::memcpy(bytes.data() + 4 * i, &value, 4);
    } else {
      std::memcpy(bytes.data() + 4 * i, &channel.values[i], 4);
    }
  }
  return bytes;
}

void write_aside(const std::filesystem::path& aside, const ExrImage& image) {
  imf::Header header(image.width, image.height);
  header.compression() = imf::ZIP_COMPRESSION;
  imf::addChromaticities(header, imf::Chromaticities());
  header.insert("colorspace", imf::StringAttribute("lin_rec709"));
  for (const auto& [key, value] : image.texts)
    header.insert(key, imf::StringAttribute(value));
  imf::FrameBuffer frame;
  std::vector<std::vector<char>> bytes;
  for (const ExrChannel& channel : image.channels) {
    header.channels().insert(channel.name, imf::Channel(pixel_type(channel.type)));
    bytes.push_back(stored(channel));
    const std::size_t width = channel.type == ExrChannel::Type::half_float ? 2 : 4;
    frame.insert(channel.name, imf::Slice(pixel_type(channel.type), bytes.back().data(), width,
                                          width * static_cast<std::size_t>(image.width)));
  }
  imf::OutputFile file(aside.c_str(), header, 0);
  file.setFrameBuffer(frame);
  file.writePixels(image.height);
}

} // namespace

Status write_exr(const std::filesystem::path& path, const ExrImage& image) {
  const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  for (const ExrChannel& channel : image.channels) {
    if (channel.values.size() != pixels)
      return make_error(ErrorCode::bad_input, "{}: channel {} has {} values; {} x {} were expected", path.string(),
                        channel.name, channel.values.size(), image.width, image.height);
  }
  const std::filesystem::path aside = path.string() + fmt::format(".part{}", ::getpid());
  try {
    write_aside(aside, image);
  } catch (const std::exception& error) {
    ::unlink(aside.c_str());
    return make_error(ErrorCode::cannot_write, "{}: cannot be written: {}", aside.string(), error.what());
  }
  if (::rename(aside.c_str(), path.c_str()) != 0) {
    const int reason = errno;
    ::unlink(aside.c_str());
    return make_error(ErrorCode::cannot_write, "{}: cannot be renamed to {}: {}", aside.string(), path.string(),
                      std::strerror(reason));
  }
  return {};
}

Result<ExrImage> read_exr(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path))
    return make_error(ErrorCode::missing_input, "there is no file {}", path.string());
  try {
    imf::InputFile file(path.c_str(), 0);
    const auto window = file.header().dataWindow();
    const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
    const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
    if (width < 1 || height < 1 || width > SIDE_MAX || height > SIDE_MAX)
      return make_error(ErrorCode::bad_input, "{}: {} x {} pixels: each side must be 1 to {}", path.string(), width,
                        height, SIDE_MAX);
    ExrImage image{static_cast<int>(width), static_cast<int>(height), {}, {}};
    for (auto i = file.header().channels().begin(); i != file.header().channels().end(); ++i) {
      ExrChannel channel;
      channel.name = i.name();
      channel.type = i.channel().type == imf::HALF   ? ExrChannel::Type::half_float
                     : i.channel().type == imf::UINT ? ExrChannel::Type::integer
                                                     : ExrChannel::Type::float32;
      channel.values.resize(static_cast<std::size_t>(width * height));
      image.channels.push_back(std::move(channel));
    }
    imf::FrameBuffer frame;
    for (ExrChannel& channel : image.channels) {
      char* base = reinterpret_cast<char*>(channel.values.data()) -
                   4 * (std::int64_t{window.min.x} + std::int64_t{window.min.y} * width);
      frame.insert(channel.name, imf::Slice(imf::FLOAT, base, 4, 4 * static_cast<std::size_t>(width)));
    }
    file.setFrameBuffer(frame);
    file.readPixels(window.min.y, window.max.y);
    for (auto i = file.header().begin(); i != file.header().end(); ++i) {
      if (const auto* text = dynamic_cast<const imf::StringAttribute*>(&i.attribute()))
        image.texts.emplace_back(i.name(), text->value());
    }
    return image;
  } catch (const std::exception& error) {
    return make_error(ErrorCode::bad_input, "{}: damaged or not OpenEXR: {}", path.string(), error.what());
  }
}

Result<LinearImage> read_exr_light(const std::filesystem::path& path) {
  const Result<ExrImage> image = read_exr(path);
  if (!image.ok())
    return image.error();
  LinearImage light{image->width, image->height, {}};
  light.pixels.assign(static_cast<std::size_t>(image->width) * static_cast<std::size_t>(image->height) * 4, 1.f);
  int found = 0;
  for (const ExrChannel& channel : image->channels) {
    const std::size_t c = channel.name == "R" ? 0 : channel.name == "G" ? 1 : channel.name == "B" ? 2 : 3;
    if (c == 3)
      continue;
    ++found;
    for (std::size_t i = 0; i < channel.values.size(); ++i)
      light.pixels[4 * i + c] = channel.values[i];
  }
  if (found != 3)
    return make_error(ErrorCode::bad_input, "{}: it has no channels R, G and B", path.string());
  return light;
}

} // namespace wry::render
