#include "render/hidden_grains.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace wry::render {

namespace {

constexpr float ROOM = 3.f; // [pixels]

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

namespace {

/// A box in clip space as x, y and distance: its middle and its half axes.
struct ClipBox {
  Vec3f centre;
  std::array<Vec3f, 3> axes;
};

/// Whether a box is behind everything that is seen where it stands, by `thickness` [m] or more.
bool is_hidden(const ClipBox& box, float thickness, float near_distance, const FarthestDepths& depths,
               const ImageSize& size) {
  const Eigen::Vector2f half(0.5f * static_cast<float>(size.width), 0.5f * static_cast<float>(size.height));
  const float reach = std::abs(box.axes[0].z()) + std::abs(box.axes[1].z()) + std::abs(box.axes[2].z());
  const float nearest = box.centre.z() - reach - thickness;
  if (!(nearest > near_distance))
    return false;
  Eigen::Vector2f low = Eigen::Vector2f::Constant(std::numeric_limits<float>::infinity()), high = -low;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3f clip = box.centre + (corner & 1 ? 1.f : -1.f) * box.axes[0] + (corner & 2 ? 1.f : -1.f) * box.axes[1] +
                       (corner & 4 ? 1.f : -1.f) * box.axes[2];
    const Eigen::Vector2f pixel = (clip.head<2>() / clip.z() + Eigen::Vector2f::Ones()).cwiseProduct(half);
    low = low.cwiseMin(pixel);
    high = high.cwiseMax(pixel);
  }
  // Off the picture: another sub-frame may move it in.
  if (!(low.x() > ROOM && low.y() > ROOM && high.x() < 2.f * half.x() - ROOM && high.y() < 2.f * half.y() - ROOM))
    return false;
  const float seen = depths.least(static_cast<int>(low.x() - ROOM), static_cast<int>(low.y() - ROOM),
                                  static_cast<int>(high.x() + ROOM), static_cast<int>(high.y() + ROOM));
  return near_distance / nearest < seen;
}

} // namespace

HidingPicture::HidingPicture(FarthestDepths depths, const Eigen::Matrix4f& clip_from_world, const ImageSize& size)
    : m_depths(std::move(depths))
    , m_linear(clip_from_world({0, 1, 3}, {0, 1, 2}))
    , m_shift(clip_from_world({0, 1, 3}, 3))
    , m_near_distance(clip_from_world(2, 3))
    , m_size(size) {}

bool HidingPicture::hides(const DrawGrain& grain) const {
  constexpr int PIECES_MAX = 6; // a long grain across the picture fits its rectangle badly: its pieces fit theirs
  ClipBox box;
  box.centre = m_linear * vector_of(grain.centre) + m_shift;
  std::array<float, 3> lengths{};
  for (std::size_t a = 0; a < 3; ++a) {
    box.axes[a] = m_linear * vector_of(grain.axes[a]);
    lengths[a] = vector_of(grain.axes[a]).norm();
  }
  const auto longest = static_cast<std::size_t>(std::max_element(lengths.begin(), lengths.end()) - lengths.begin());
  const float thickness = 2.f * *std::min_element(lengths.begin(), lengths.end());
  if (is_hidden(box, thickness, m_near_distance, m_depths, m_size))
    return true;
  const float width = std::max(lengths[(longest + 1) % 3], lengths[(longest + 2) % 3]);
  const int pieces = std::clamp(static_cast<int>(lengths[longest] / std::max(width, 1e-12f)), 1, PIECES_MAX);
  const Vec3f along = box.axes[longest];
  const Vec3f middle = box.centre;
  box.axes[longest] = along / static_cast<float>(pieces);
  bool all = pieces > 1;
  for (int piece = 0; piece < pieces && all; ++piece) {
    box.centre = middle + along * (static_cast<float>(2 * piece + 1) / static_cast<float>(pieces) - 1.f);
    all = is_hidden(box, thickness, m_near_distance, m_depths, m_size);
  }
  return all;
}

std::vector<std::uint32_t> nearest_in_cells(std::span<const Eigen::Vector3f> places, float cell, std::size_t most) {
  if (places.empty() || most == 0)
    return {};
  constexpr float CELLS_MAX = 1024.f; // on a side
  Eigen::Vector2f low = places[0].head<2>(), high = low;
  for (const Vec3f& place : places) {
    low = low.cwiseMin(place.head<2>());
    high = high.cwiseMax(place.head<2>());
  }
  const float side = std::max({cell, (high - low).maxCoeff() / CELLS_MAX, 1e-6f});
  const auto cells_along = [&](int axis) { return static_cast<std::size_t>((high[axis] - low[axis]) / side) + 1; };
  const std::size_t columns = cells_along(0);
  // Sorted by cell: the places of cell c are those from begins[c] to begins[c + 1].
  std::vector<std::uint32_t> cell_of(places.size());
  std::vector<std::uint32_t> begins(columns * cells_along(1) + 1, 0);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Eigen::Vector2f at = (places[i].head<2>() - low) / side;
    cell_of[i] =
        static_cast<std::uint32_t>(static_cast<std::size_t>(at.y()) * columns + static_cast<std::size_t>(at.x()));
    ++begins[cell_of[i] + 1];
  }
  std::partial_sum(begins.begin(), begins.end(), begins.begin());
  std::vector<std::pair<float, std::uint32_t>> sorted(places.size());
  std::vector<std::uint32_t> next(begins.begin(), begins.end() - 1);
  for (std::uint32_t i = 0; i < places.size(); ++i)
    sorted[next[cell_of[i]]++] = {places[i].z(), i};
  std::vector<std::uint32_t> chosen;
  for (std::size_t c = 0; c + 1 < begins.size(); ++c) {
    const auto begin = sorted.begin() + begins[c];
    const auto end = sorted.begin() + begins[c + 1];
    const auto count = std::min(static_cast<std::ptrdiff_t>(most), end - begin);
    if (count < end - begin)
      std::nth_element(begin, begin + count, end);
    for (auto it = begin; it != begin + count; ++it)
      chosen.push_back(it->second);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

GrainPlaces grain_places(std::span<const DrawGrain> grains, const Eigen::Matrix4f& clip_from_world,
                         const ImageSize& size) {
  const Eigen::Vector2f half(0.5f * static_cast<float>(size.width), 0.5f * static_cast<float>(size.height));
  const float pixels = clip_from_world.row(0).head<3>().norm() * half.x(); // that a metre across has at 1 m
  const float near_distance = clip_from_world(2, 3);
  GrainPlaces found;
  found.places.reserve(grains.size());
  double area = 0.0;
  for (const DrawGrain& grain : grains) {
    const Vec3f centre =
        clip_from_world({0, 1, 3}, {0, 1, 2}) * vector_of(grain.centre) + clip_from_world({0, 1, 3}, 3);
    const float distance = std::max(centre.z(), near_distance);
    const Eigen::Vector2f at = (centre.head<2>() / distance + Eigen::Vector2f::Ones()).cwiseProduct(half);
    found.places.emplace_back(std::clamp(at.x(), 0.f, 2.f * half.x()), std::clamp(at.y(), 0.f, 2.f * half.y()),
                              centre.z());
    std::array<float, 3> lengths{};
    for (std::size_t a = 0; a < 3; ++a)
      lengths[a] = 2.f * vector_of(grain.axes[a]).norm() * pixels / distance;
    std::sort(lengths.begin(), lengths.end());
    area += static_cast<double>(lengths[1] * lengths[2]);
  }
  found.side = static_cast<float>(std::sqrt(area / std::max(static_cast<double>(grains.size()), 1.0)));
  return found;
}

OutlineOrder::OutlineOrder(std::span<const std::array<float, 3>> corners, const Eigen::Matrix4f& clip_from_world,
                           int map_size)
    : m_map_size(map_size) {
  constexpr std::size_t CORNERS = 4;
  const float half = 0.5f * static_cast<float>(map_size);
  const auto texels = [&](const std::array<float, 3>& place) {
    const Vec3f clip =
        clip_from_world.topLeftCorner<3, 3>() * vector_of(place) + clip_from_world.topRightCorner<3, 1>();
    return Vec3f(half * (clip.x() + 1.f), half * (clip.y() + 1.f), clip.z());
  };
  m_outlines.reserve(corners.size() / CORNERS);
  double area = 0.0;
  for (std::size_t first = 0; first + CORNERS <= corners.size(); first += CORNERS) {
    const Vec3f corner = texels(corners[first]);
    Vec3f along = texels(corners[first + 1]) - corner;
    Vec3f across = texels(corners[first + 3]) - corner;
    area += static_cast<double>(std::abs(along.x() * across.y() - along.y() * across.x()));
    if (along.head<2>().squaredNorm() < across.head<2>().squaredNorm())
      along.swap(across);
    m_outlines.push_back({corner, along, across});
  }
  m_left.resize(m_outlines.size());
  std::iota(m_left.begin(), m_left.end(), 0u);
  m_side = static_cast<float>(std::sqrt(area / std::max(static_cast<double>(m_outlines.size()), 1.0)));
}

OutlineOrder::Reach OutlineOrder::reach_of(const Outline& outline) {
  const Vec3f zero = Vec3f::Zero();
  const Vec3f low = outline.corner + outline.along.cwiseMin(zero) + outline.across.cwiseMin(zero);
  const Vec3f high = outline.corner + outline.along.cwiseMax(zero) + outline.across.cwiseMax(zero);
  return {low.x(), low.y(), high.x(), high.y(), low.z()};
}

std::vector<std::uint32_t> OutlineOrder::first_met(std::size_t most) {
  std::vector<Vec3f> places;
  places.reserve(m_left.size());
  for (const std::uint32_t i : m_left) {
    const Outline& outline = m_outlines[i];
    const Vec3f middle = outline.corner + 0.5f * (outline.along + outline.across);
    places.emplace_back(middle.x(), middle.y(), reach_of(outline).nearest);
  }
  std::vector<std::uint32_t> chosen = nearest_in_cells(places, m_side, most);
  std::vector<std::uint8_t> taken(m_left.size(), 0);
  for (std::uint32_t& place : chosen) {
    taken[place] = 1;
    place = m_left[place];
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < m_left.size(); ++i) {
    if (taken[i] == 0)
      m_left[kept++] = m_left[i];
  }
  m_left.resize(kept);
  return chosen;
}

bool OutlineOrder::is_hidden(const Reach& reach, const FarthestDepths& depths) const {
  constexpr float SAFE = 1e-6f; // what a raster and this code may round differently
  const float side = static_cast<float>(m_map_size);
  const bool inside = reach.left > 1.f && reach.bottom > 1.f && reach.right < side - 1.f && reach.top < side - 1.f;
  return inside && 1.f - reach.nearest + SAFE <
                       depths.least(static_cast<int>(reach.left - 1.f), static_cast<int>(reach.bottom - 1.f),
                                    static_cast<int>(reach.right + 1.f), static_cast<int>(reach.top + 1.f));
}

/// As a whole or piece by piece: what lies askew fits its rectangle badly.
bool OutlineOrder::is_hidden(const Outline& outline, const FarthestDepths& depths) const {
  constexpr int PIECES_MAX = 6;
  if (is_hidden(reach_of(outline), depths))
    return true;
  const float ratio = outline.along.head<2>().norm() / std::max(outline.across.head<2>().norm(), 1.f);
  const int pieces = std::clamp(static_cast<int>(ratio), 1, PIECES_MAX);
  Outline piece = outline;
  piece.along /= static_cast<float>(pieces);
  bool all = pieces > 1;
  for (int i = 0; i < pieces && all; ++i) {
    piece.corner = outline.corner + static_cast<float>(i) * piece.along;
    all = is_hidden(reach_of(piece), depths);
  }
  return all;
}

std::vector<std::uint32_t> OutlineOrder::seen_of_the_rest(std::vector<float> depth) const {
  // The least of what grows towards the light is the farthest.
  for (float& d : depth)
    d = 1.f - d;
  const FarthestDepths farthest(std::move(depth), {m_map_size, m_map_size});
  std::vector<std::uint32_t> chosen;
  for (const std::uint32_t i : m_left) {
    if (!is_hidden(m_outlines[i], farthest))
      chosen.push_back(i);
  }
  return chosen;
}

} // namespace wry::render
