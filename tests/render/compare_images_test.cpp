#include <gtest/gtest.h>

#include "render/compare_images.h"

namespace wry::render {
namespace {

Image plain(int width, int height, std::uint8_t level) {
  Image image(width, height);
  std::fill(image.pixels.begin(), image.pixels.end(), level);
  return image;
}

TEST(Compare, SplitTakesEachSideFromItsPicture) {
  const Result<Image> split = split_images(plain(400, 100, 40), plain(400, 100, 90), "before", "after");
  ASSERT_TRUE(split.ok());
  EXPECT_EQ(split->at(10, 90)[0], 40);
  EXPECT_EQ(split->at(390, 90)[0], 90);
}

TEST(Compare, DifferenceCountsMeanGreatestAndPixels) {
  Image a = plain(200, 200, 50);
  Image b = a;
  b.at(3, 4)[1] = 70;
  b.at(5, 6)[2] = 60;
  const Result<ImageDifference> found = difference_of_images(a, b, 20.0);
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found->greatest, 20.0);
  EXPECT_EQ(found->pixels_apart, 2);
  EXPECT_NEAR(found->mean, 30.0 / 40000.0, 1e-12);
  EXPECT_NE(found->map.at(3, 4)[0], found->map.at(100, 100)[0]);
}

TEST(Compare, PicturesOfOtherSizesAreRefused) {
  EXPECT_FALSE(split_images(plain(10, 10, 0), plain(11, 10, 0), "", "").ok());
  EXPECT_FALSE(difference_of_images(plain(10, 10, 0), plain(10, 9, 0), 1.0).ok());
}

} // namespace
} // namespace wry::render
