#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace wry::render {

/// A display-ready picture: sRGB-encoded 8-bit red, green, blue and straight alpha, rows from the top.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels; ///< height x width x 4
  std::vector<std::uint16_t> deep;  ///< the same with 16 bits; empty: there are only 8

  Image() = default;
  /// All pixels zero (transparent black).
  Image(int image_width, int image_height)
      : width(image_width)
      , height(image_height)
      , pixels(static_cast<std::size_t>(image_width) * static_cast<std::size_t>(image_height) * 4, 0) {}

  std::uint8_t* at(int x, int y) { return pixels.data() + offset(x, y); }
  const std::uint8_t* at(int x, int y) const { return pixels.data() + offset(x, y); }

private:
  std::size_t offset(int x, int y) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) * 4;
  }
};

/// Scene-linear light before exposure and tone curve (Rec. 709 primaries), rows from the top.
struct LinearImage {
  int width = 0;
  int height = 0;
  std::vector<float> pixels; ///< height x width x 4: red, green, blue, coverage of the subject

  const float* at(int x, int y) const {
    return pixels.data() +
           (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) * 4;
  }
};

} // namespace wry::render
