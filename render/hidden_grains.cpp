#include "render/hidden_grains.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace wry::render {

namespace {

constexpr float ROOM = 2.f; // [pixels]

using Vec3f = Eigen::Vector3f;

Vec3f vector_of(const std::array<float, 3>& values) {
  return Vec3f(values[0], values[1], values[2]);
}

} // namespace

FarthestDepths::FarthestDepths(std::vector<float> depth, const ImageSize& size) {
  m_levels.push_back({size.width, size.height, std::move(depth)});
  while (m_levels.back().width > 1 || m_levels.back().height > 1) {
    const Level& below = m_levels.back();
    Level level{(below.width + 1) / 2, (below.height + 1) / 2, {}};
    level.least.resize(static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height));
    for (int y = 0; y < level.height; ++y) {
      const float* first = below.least.data() + static_cast<std::ptrdiff_t>(2 * y) * below.width;
      const float* second = 2 * y + 1 < below.height ? first + below.width : first;
      float* out = level.least.data() + static_cast<std::ptrdiff_t>(y) * level.width;
      for (int x = 0; x < level.width; ++x) {
        const int right = std::min(2 * x + 1, below.width - 1);
        out[x] = std::min(std::min(first[2 * x], first[right]), std::min(second[2 * x], second[right]));
      }
    }
    m_levels.push_back(std::move(level));
  }
}

float FarthestDepths::least(int left, int bottom, int right, int top) const {
  left = std::clamp(left, 0, m_levels[0].width - 1);
  right = std::clamp(right, left, m_levels[0].width - 1);
  bottom = std::clamp(bottom, 0, m_levels[0].height - 1);
  top = std::clamp(top, bottom, m_levels[0].height - 1);
  constexpr int FEW = 4;
  std::size_t level = 0;
  while (((right >> level) - (left >> level) >= FEW || (top >> level) - (bottom >> level) >= FEW) &&
         level + 1 < m_levels.size())
    ++level;
  const Level& chosen = m_levels[level];
  float least = std::numeric_limits<float>::infinity();
  for (int y = bottom >> level; y <= top >> level; ++y) {
    for (int x = left >> level; x <= right >> level; ++x)
      least = std::min(least, chosen.least[static_cast<std::size_t>(y) * static_cast<std::size_t>(chosen.width) +
                                           static_cast<std::size_t>(x)]);
  }
  return least;
}

std::vector<std::uint8_t> hidden_grains(std::span<const DrawGrain> grains, const Eigen::Matrix4f& clip_from_world,
                                        const FarthestDepths& depths, const ImageSize& size) {
  const Eigen::Vector2f half(0.5f * static_cast<float>(size.width), 0.5f * static_cast<float>(size.height));
  const Eigen::Matrix3f linear = clip_from_world({0, 1, 3}, {0, 1, 2}); // x, y and distance
  const Vec3f shift = clip_from_world({0, 1, 3}, 3);
  const float near_distance = clip_from_world(2, 3);
  std::vector<std::uint8_t> hidden(grains.size(), 0);
  for (std::size_t i = 0; i < grains.size(); ++i) {
    const Vec3f centre = linear * vector_of(grains[i].centre) + shift;
    std::array<Vec3f, 3> axes;
    float reach = 0.f, thickness = std::numeric_limits<float>::infinity();
    for (std::size_t a = 0; a < 3; ++a) {
      axes[a] = linear * vector_of(grains[i].axes[a]);
      reach += std::abs(axes[a].z());
      thickness = std::min(thickness, 2.f * vector_of(grains[i].axes[a]).norm());
    }
    const float nearest = centre.z() - reach - thickness;
    if (!(nearest > near_distance))
      continue;
    Eigen::Vector2f low = Eigen::Vector2f::Constant(std::numeric_limits<float>::infinity()), high = -low;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3f clip = centre + (corner & 1 ? 1.f : -1.f) * axes[0] + (corner & 2 ? 1.f : -1.f) * axes[1] +
                         (corner & 4 ? 1.f : -1.f) * axes[2];
      const Eigen::Vector2f pixel = (clip.head<2>() / clip.z() + Eigen::Vector2f::Ones()).cwiseProduct(half);
      low = low.cwiseMin(pixel);
      high = high.cwiseMax(pixel);
    }
    // Off the picture: another sub-frame may move it in.
    if (!(low.x() > ROOM && low.y() > ROOM && high.x() < 2.f * half.x() - ROOM && high.y() < 2.f * half.y() - ROOM))
      continue;
    const float seen = depths.least(static_cast<int>(low.x() - ROOM), static_cast<int>(low.y() - ROOM),
                                    static_cast<int>(high.x() + ROOM), static_cast<int>(high.y() + ROOM));
    hidden[i] = near_distance / nearest < seen ? 1 : 0;
  }
  return hidden;
}

} // namespace wry::render
