#include <gtest/gtest.h>

#include "render/passes/picture_tiles.h"

namespace wry::render {
namespace {

constexpr ImageSize SIZE{100, 70}; // seven tiles by five, those at the right and at the top cut off

std::vector<float> empty_depths() {
  return std::vector<float>(static_cast<std::size_t>(SIZE.width) * static_cast<std::size_t>(SIZE.height), 0.f);
}

float& at(std::vector<float>& depths, int x, int y) {
  return depths[static_cast<std::size_t>(y) * static_cast<std::size_t>(SIZE.width) + static_cast<std::size_t>(x)];
}

/// How often each pixel is in the rectangles.
std::vector<int> cover(const std::vector<PixelRect>& rects) {
  std::vector<int> times(static_cast<std::size_t>(SIZE.width) * static_cast<std::size_t>(SIZE.height), 0);
  for (const PixelRect& rect : rects) {
    EXPECT_LE(rect.x + rect.width, SIZE.width);
    EXPECT_LE(rect.y + rect.height, SIZE.height);
    for (int y = rect.y; y < rect.y + rect.height; ++y) {
      for (int x = rect.x; x < rect.x + rect.width; ++x)
        ++times[static_cast<std::size_t>(y) * static_cast<std::size_t>(SIZE.width) + static_cast<std::size_t>(x)];
    }
  }
  return times;
}

int pixels(const std::vector<PixelRect>& rects) {
  int sum = 0;
  for (const int times : cover(rects))
    sum += times;
  return sum;
}

TEST(PictureTiles, APictureWithoutASubjectIsStillEverywhereAndOneRectangle) {
  PictureTiles tiles(SIZE);
  tiles.take_depths(empty_depths());
  ASSERT_EQ(tiles.still().size(), 1U);
  EXPECT_EQ(pixels(tiles.still()), SIZE.width * SIZE.height);
  EXPECT_TRUE(tiles.open_subject().empty());
  EXPECT_TRUE(tiles.open_floor().empty());
}

TEST(PictureTiles, EveryPixelIsEitherStillOrDrawnInEachSubFrame) {
  PictureTiles tiles(SIZE);
  std::vector<float> depths = empty_depths();
  at(depths, 20, 20) = .5f;
  at(depths, 99, 69) = .5f;
  std::vector<std::array<std::uint8_t, 4>> occlusion(depths.size(), {255, 0, 0, 255});
  occlusion[50 * 100 + 50][2] = 1;
  tiles.take_blockers(occlusion);
  tiles.take_depths(depths);
  std::vector<int> times = cover(tiles.still());
  for (const std::vector<PixelRect>& more : {tiles.shaded_floor(), tiles.open_floor()}) {
    const std::vector<int> added = cover(more);
    for (std::size_t i = 0; i < times.size(); ++i)
      times[i] += added[i];
  }
  for (const int number : times)
    EXPECT_EQ(number, 1);
  EXPECT_EQ(cover(tiles.open_subject())[20 * 100 + 20], 1);
  EXPECT_EQ(cover(tiles.shaded_floor())[(50 + PictureTiles::SIDE) * 100 + 50], 1) << "next to what is blocked";
}

TEST(PictureTiles, ATileThatTheSubjectEntersLaterOwesItsFloorOnce) {
  PictureTiles tiles(SIZE);
  std::vector<float> depths = empty_depths();
  tiles.take_depths(depths);
  at(depths, 40, 40) = .5f;
  tiles.take_depths(depths);
  EXPECT_EQ(pixels(tiles.newly_busy()), PictureTiles::SIDE * PictureTiles::SIDE);
  tiles.take_depths(empty_depths());
  EXPECT_TRUE(tiles.newly_busy().empty());
  EXPECT_TRUE(tiles.open_subject().empty());
  EXPECT_EQ(pixels(tiles.open_floor()), PictureTiles::SIDE * PictureTiles::SIDE) << "it is drawn from now on";
}

TEST(PictureTiles, ATileFullOfTheSubjectShowsNoFloor) {
  PictureTiles tiles(SIZE);
  tiles.take_depths(std::vector<float>(empty_depths().size(), .5f));
  EXPECT_TRUE(tiles.open_floor().empty());
  EXPECT_TRUE(tiles.shaded_floor().empty());
  EXPECT_EQ(pixels(tiles.open_subject()), SIZE.width * SIZE.height);
}

TEST(PictureTiles, TilesAboutWhatIsEnclosedAreAllThatIsEnlarged) {
  constexpr ImageSize HALF{50, 35};
  constexpr std::uint16_t ONE = 0x3C00, NEARLY = 0x3BF0;
  const std::vector<std::array<std::uint16_t, 4>> open(50 * 35, {ONE, 0, 0, ONE});
  PictureTiles tiles(SIZE);
  tiles.take_enclosed(open, HALF);
  EXPECT_TRUE(tiles.enclosed().empty());
  for (const std::array<std::uint16_t, 4>& there :
       {std::array<std::uint16_t, 4>{NEARLY, 0, 0, ONE}, {ONE, 0, 1, ONE}}) {
    std::vector<std::array<std::uint16_t, 4>> mean = open;
    mean[17 * 50 + 25] = there; // tile 3, 2
    tiles.clear();
    tiles.take_enclosed(mean, HALF);
    EXPECT_EQ(pixels(tiles.enclosed()), 48 * 48);
    EXPECT_EQ(cover(tiles.enclosed())[34 * 100 + 50], 1);
  }
}

} // namespace
} // namespace wry::render
