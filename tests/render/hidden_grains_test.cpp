#include "render/hidden_grains.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace wry::render {
namespace {

constexpr ImageSize SIZE{64, 48};
constexpr float NEAR_DISTANCE = 0.1f;

/// An eye at the origin that looks along -z, as wide as high.
Eigen::Matrix4f clip() {
  Eigen::Matrix4f matrix = Eigen::Matrix4f::Zero();
  matrix(0, 0) = 1.f;
  matrix(1, 1) = 64.f / 48.f;
  matrix(2, 3) = NEAR_DISTANCE;
  matrix(3, 2) = -1.f;
  return matrix;
}

DrawGrain cube(float x, float y, float distance, float half) {
  return {{x, y, -distance}, {{{half, 0, 0}, {0, half, 0}, {0, 0, half}}}, {0, 0, 0}, 0};
}

/// A wall at 2 m over all of the picture but the pixels from `open` on to the right.
FarthestDepths wall(int open) {
  std::vector<float> depth;
  for (int y = 0; y < SIZE.height; ++y) {
    for (int x = 0; x < SIZE.width; ++x)
      depth.push_back(x < open ? NEAR_DISTANCE / 2.f : 0.f);
  }
  return {std::move(depth), SIZE};
}

TEST(HiddenGrains, AreThoseBehindAllThatIsSeenAroundThem) {
  const std::vector<DrawGrain> grains = {
      cube(0, 0, 3.f, 0.05f),   // behind
      cube(0, 0, 1.5f, 0.05f),  // before
      cube(0, 0, 2.12f, 0.05f), // behind by less than its thickness
      cube(3.f, 0, 3.1f, 0.3f), // its edge is off the picture
      cube(0, 0, 0.12f, 0.05f), // about the eye
  };
  const HidingPicture picture(wall(SIZE.width), clip(), SIZE);
  std::vector<bool> hidden;
  for (const DrawGrain& grain : grains)
    hidden.push_back(picture.hides(grain));
  EXPECT_EQ(hidden, (std::vector<bool>{true, false, false, false, false}));
}

TEST(HiddenGrains, AreSeenThroughAGapNearThem) {
  // At 3 m a pixel is 3/32 m; the grain covers columns 31 and 32, and two more on either side count.
  const DrawGrain grain = cube(0, 0, 3.f, 0.05f);
  for (int open = 20; open <= 34; ++open)
    EXPECT_FALSE(HidingPicture(wall(open), clip(), SIZE).hides(grain)) << open;
  for (int open = 37; open < 50; ++open) // what is looked at in pairs of columns may be a little wider
    EXPECT_TRUE(HidingPicture(wall(open), clip(), SIZE).hides(grain)) << open;
}

TEST(HiddenGrains, FarthestDepthsAreNeverNearerThanThoseOfTheRectangle) {
  std::vector<float> depth;
  for (int i = 0; i < SIZE.width * SIZE.height; ++i)
    depth.push_back(static_cast<float>((i * 7919) % 1009));
  const FarthestDepths depths(depth, SIZE);
  for (int left = 0; left < SIZE.width; left += 5) {
    for (int width = 0; width < 40; width += 3) {
      float truth = 1e9f, around = 1e9f;
      for (int y = 0; y < SIZE.height; ++y) {
        for (int x = 0; x < SIZE.width; ++x) {
          const float value = depth[static_cast<std::size_t>(y * SIZE.width + x)];
          if (x >= left && x <= left + width && y >= 10 && y <= 10 + width / 2)
            truth = std::min(truth, value);
          if (x >= left - width && x <= left + 2 * width && y >= 10 - width && y <= 10 + 2 * width)
            around = std::min(around, value);
        }
      }
      const float found = depths.least(left, 10, left + width, 10 + width / 2);
      EXPECT_LE(found, truth);
      EXPECT_GE(found, around);
    }
  }
}

TEST(NearestInCells, AreThoseWithFewNearerOnesInTheirCell) {
  // Two cells of four pixels, the second with one point only; of equals the first in order counts as nearer.
  const std::vector<Eigen::Vector3f> places = {{0, 0, 5}, {1, 3, 2}, {3, 1, 9}, {2, 2, 2}, {3, 3, 1}, {7, 0, 50}};
  EXPECT_EQ(nearest_in_cells(places, 4.f, 1), (std::vector<std::uint32_t>{4, 5}));
  EXPECT_EQ(nearest_in_cells(places, 4.f, 2), (std::vector<std::uint32_t>{1, 4, 5}));
  EXPECT_EQ(nearest_in_cells(places, 4.f, 4), (std::vector<std::uint32_t>{0, 1, 3, 4, 5}));
  EXPECT_EQ(nearest_in_cells(places, 4.f, 9).size(), places.size());
  EXPECT_TRUE(nearest_in_cells({}, 4.f, 9).empty());
}

/// Squares of two by two across the light, at these depths, all about the middle of the map.
std::vector<std::array<float, 3>> squares(const std::vector<float>& sides, const std::vector<float>& depths) {
  std::vector<std::array<float, 3>> corners;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    for (const auto& [x, y] : {std::pair(-1.f, -1.f), std::pair(1.f, -1.f), std::pair(1.f, 1.f), std::pair(-1.f, 1.f)})
      corners.push_back({sides[i] * x, sides[i] * y, depths[i]});
  }
  return corners;
}

TEST(OutlineOrder, OnlyWhatIsWhollyBehindIsLeftOut) {
  // The second peeps out from behind the first; the third does not; the fourth lies before what is drawn.
  OutlineOrder order(squares({.25f, .5f, .125f, .125f}, {.2f, .6f, .7f, .4f}), Eigen::Matrix4f::Identity(), 64);
  EXPECT_EQ(order.first_met(1), std::vector<std::uint32_t>{0});
  std::vector<float> depth(64 * 64, 1.f);
  for (int y = 24; y < 40; ++y) {
    for (int x = 24; x < 40; ++x)
      depth[static_cast<std::size_t>(64 * y + x)] = .5f;
  }
  EXPECT_EQ(order.seen_of_the_rest(depth), (std::vector<std::uint32_t>{1, 3}));
}

TEST(OutlineOrder, NothingIsDrawnTwiceOrForgottenOverAnEmptyMap) {
  std::vector<float> sides, depths;
  for (int i = 0; i < 40; ++i) {
    sides.push_back(.01f * static_cast<float>(i));
    depths.push_back(static_cast<float>((i * 7) % 40) / 40.f);
  }
  OutlineOrder order(squares(sides, depths), Eigen::Matrix4f::Identity(), 64);
  std::vector<std::uint32_t> drawn = order.first_met(3);
  const std::vector<std::uint32_t> rest = order.seen_of_the_rest(std::vector<float>(64 * 64, 1.f));
  drawn.insert(drawn.end(), rest.begin(), rest.end());
  std::sort(drawn.begin(), drawn.end());
  ASSERT_EQ(drawn.size(), 40U);
  for (std::uint32_t i = 0; i < 40; ++i)
    EXPECT_EQ(drawn[i], i);
}

} // namespace
} // namespace wry::render
