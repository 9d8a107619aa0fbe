#include "render/color_map.h"

#include <algorithm>
#include <cstddef>

namespace wry::render {
namespace {

constexpr DisplayColour bytes(int red, int green, int blue) {
  return {static_cast<float>(red) / 255.f, static_cast<float>(green) / 255.f, static_cast<float>(blue) / 255.f};
}

constexpr std::array<DisplayColour, 10> VIRIDIS = {
    bytes(68, 1, 84),    bytes(72, 40, 120),  bytes(62, 74, 137),  bytes(49, 104, 142), bytes(38, 130, 142),
    bytes(31, 158, 137), bytes(53, 183, 121), bytes(110, 206, 88), bytes(181, 222, 43), bytes(253, 231, 37)};

} // namespace

std::span<const DisplayColour> heat_colours() {
  return VIRIDIS;
}

DisplayColour heat_colour(double t) {
  const double place = std::clamp(t, 0.0, 1.0) * static_cast<double>(VIRIDIS.size() - 1);
  const std::size_t low = std::min(static_cast<std::size_t>(place), VIRIDIS.size() - 2);
  const float part = static_cast<float>(place - static_cast<double>(low));
  DisplayColour colour{};
  for (std::size_t c = 0; c < 3; ++c)
    colour[c] = VIRIDIS[low][c] + part * (VIRIDIS[low + 1][c] - VIRIDIS[low][c]);
  return colour;
}

} // namespace wry::render
