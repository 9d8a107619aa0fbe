#include "render/overlay.h"

#include <gmock/gmock.h>

#include "render/contact_sheet.h"
#include "render/text/draw_text.h"
#include "render/text/font.h"

namespace wry::render {
namespace {

using ::testing::ElementsAre;

Image filled(int width, int height, const DisplayColour& colour) {
  Image image(width, height);
  fill_rectangle(image, 0, 0, width, height, colour, 1.F);
  return image;
}

TEST(Font, DrawsEveryPrintableLetterOfAsciiAndEachDifferently) {
  const std::size_t missing = glyph(U'\u4e00').strokes.size();
  for (char32_t letter = 33; letter < 127; ++letter) {
    const Glyph& drawn = glyph(letter);
    ASSERT_FALSE(drawn.strokes.empty()) << static_cast<int>(letter);
    for (char32_t other = 33; other < letter; ++other) {
      const Glyph& earlier = glyph(other);
      const bool same = drawn.strokes.size() == earlier.strokes.size() &&
                        std::equal(drawn.strokes.begin(), drawn.strokes.end(), earlier.strokes.begin(),
                                   [](const Stroke& a, const Stroke& b) { return a.from == b.from && a.to == b.to; });
      EXPECT_FALSE(same) << static_cast<char>(letter) << " looks like " << static_cast<char>(other);
    }
  }
  EXPECT_GT(missing, 0U);
}

TEST(Font, ReadsUtf8AndSurvivesWhatIsNot) {
  EXPECT_EQ(letters_of("5\u00b0"), std::u32string(U"5\u00b0"));
  EXPECT_EQ(letters_of("a\xC3").size(), 2U);
  EXPECT_EQ(letters_of("\xFF\xFE").size(), 2U);
}

TEST(Text, StaysWithinItsWidthAndChangesNothingElse) {
  Image image = filled(200, 60, {0.5F, 0.5F, 0.5F});
  TextStyle style;
  style.halo = 0.F;
  draw_text(image, 20, 40, "Wry 42", style);
  const int right = static_cast<int>(20 + text_width("Wry 42", style));
  int bright = 0;
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 200; ++x) {
      const bool inside = x >= 18 && x <= right && y >= 22 && y <= 47;
      if (!inside) {
        ASSERT_EQ(image.at(x, y)[0], 128) << x << " " << y;
      }
      bright += image.at(x, y)[0] > 230 ? 1 : 0;
    }
  }
  EXPECT_GT(bright, 150);
}

TEST(Text, MayLieOutsideThePicture) {
  Image image = filled(30, 30, {0.F, 0.F, 0.F});
  draw_text(image, -100, 10, "far off", {});
  draw_text(image, 10, 500, "far off", {});
  draw_text(image, 20, 20, "half", {});
}

TEST(ColourBar, TicksAreRoundAndWithinTheRange) {
  EXPECT_THAT(round_ticks(0.0, 1.0, 5),
              ElementsAre(0.0, ::testing::DoubleNear(0.2, 1e-12), 0.4, ::testing::DoubleNear(0.6, 1e-12), 0.8, 1.0));
  EXPECT_THAT(round_ticks(-3.0, 7.0, 5), ElementsAre(-2.0, 0.0, 2.0, 4.0, 6.0));
  for (const auto& [low, high] : {std::pair(1e-7, 3e-7), std::pair(-5e8, 1e8), std::pair(0.99, 1.01)}) {
    const std::vector<double> ticks = round_ticks(low, high, 6);
    ASSERT_GE(ticks.size(), 3U);
    EXPECT_GE(ticks.front(), low - 1e-9 * (high - low));
    EXPECT_LE(ticks.back(), high + 1e-9 * (high - low));
  }
}

TEST(ColourBar, ShowsTheEndsOfTheMap) {
  Image image = filled(640, 360, {0.5F, 0.5F, 0.5F});
  draw_colour_bar(image, {.channel = "speed", .low = 0, .high = 2, .title = "", .unit = "m/s"});
  const auto has = [&](const DisplayColour& colour) {
    for (std::size_t i = 0; i < image.pixels.size(); i += 4) {
      if (std::abs(image.pixels[i] - 255.F * colour[0]) < 3.F &&
          std::abs(image.pixels[i + 1] - 255.F * colour[1]) < 3.F &&
          std::abs(image.pixels[i + 2] - 255.F * colour[2]) < 3.F)
        return true;
    }
    return false;
  };
  EXPECT_TRUE(has(heat_colour(0.0)));
  EXPECT_TRUE(has(heat_colour(0.5)));
  EXPECT_TRUE(has(heat_colour(1.0)));
}

TEST(ContactSheet, HoldsEveryPictureInItsPlace) {
  std::vector<SheetEntry> entries;
  for (int i = 0; i < 5; ++i)
    entries.push_back({filled(160, 90, {0.2F * static_cast<float>(i), 0.F, 1.F}), "case"});
  const Result<Image> sheet = make_contact_sheet(entries, {.columns = 3, .cell_width = 80});
  ASSERT_TRUE(sheet.ok());
  const int gap = 4;
  for (int i = 0; i < 5; ++i) {
    const int x = gap + (i % 3) * (80 + gap) + 40;
    const int row_height = (sheet->height - gap) / 2;
    const int y = gap + (i / 3) * row_height + 20;
    EXPECT_NEAR(sheet->at(x, y)[0], 51 * i, 1) << i;
    EXPECT_EQ(sheet->at(x, y)[2], 255) << i;
  }
  EXPECT_FALSE(make_contact_sheet({}).ok());
}

TEST(ContactSheet, WithHeadsHasARowPerHeadAndWordsAboveAndBeside) {
  const std::vector<SheetEntry> entries(6, {filled(80, 40, {1.F, 0.F, 0.F}), ""});
  const Result<Image> plain = make_contact_sheet(entries, {.columns = 3, .cell_width = 80});
  const Result<Image> headed = make_contact_sheet(
      entries, {.columns = 1, .cell_width = 80, .column_heads = {"a", "b", "c"}, .row_heads = {"first", "the second"}});
  ASSERT_TRUE(plain.ok() && headed.ok());
  const int left = headed->width - plain->width, top = headed->height - plain->height;
  EXPECT_GT(left, 40);
  EXPECT_GT(top, 10);
  const auto words_in = [&](int x0, int y0, int x1, int y1) {
    int bright = 0;
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x)
        bright += headed->at(x, y)[1] > 150 ? 1 : 0;
    return bright;
  };
  EXPECT_GT(words_in(left, 0, headed->width, top), 20) << "over the columns";
  EXPECT_GT(words_in(0, top, left, headed->height), 40) << "before the rows";
  EXPECT_EQ(words_in(left, top, headed->width, headed->height), 0) << "and not over the pictures";
}

TEST(ContactSheet, ShrinkingKeepsTheMeanOfTheLight) {
  Image checks(64, 64);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x)
      fill_rectangle(checks, x, y, 1, 1, (x + y) % 2 == 0 ? DisplayColour{1.F, 1.F, 1.F} : DisplayColour{0.F, 0.F, 0.F},
                     1.F);
  }
  const Image small = shrunk(checks, 32, 32);
  EXPECT_EQ(small.at(16, 16)[0], 188); // half the light of white, encoded
}

} // namespace
} // namespace wry::render
