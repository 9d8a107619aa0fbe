#include "shots/frame_range.h"

#include <gmock/gmock.h>

namespace wry::shots {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(FrameRange, ReadsRangesStepsAndSingleFrames) {
  EXPECT_THAT(FrameRange::parse("1-4")->frames(), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(FrameRange::parse("1001-1006x2, 1150")->frames(), ElementsAre(1001, 1003, 1005, 1150));
  EXPECT_THAT(FrameRange::parse("7")->frames(), ElementsAre(7));
}

TEST(FrameRange, SortsAndKeepsEachFrameOnce) {
  EXPECT_THAT(FrameRange::parse("5,1-3,2-4")->frames(), ElementsAre(1, 2, 3, 4, 5));
}

TEST(FrameRange, CanonicalTextGivesTheSameSet) {
  for (const char* text : {"1-120", "1001-1100x2,1150", "7", "1,3", "1,3,5,6,7,9", "0-30x10,31-33", "1,2", "2,1"}) {
    const FrameRange range = *FrameRange::parse(text);
    EXPECT_EQ(FrameRange::parse(range.text())->frames(), range.frames()) << text << " became " << range.text();
  }
  EXPECT_EQ(FrameRange::parse("1,2,3,4")->text(), "1-4");
  EXPECT_EQ(FrameRange::parse("1,3,5")->text(), "1-5x2");
  EXPECT_EQ(FrameRange::parse("1,3")->text(), "1,3");
}

TEST(FrameRange, RefusesWhatIsNoRange) {
  for (const char* text : {"", " ", "a", "1-", "-3", "1--3", "1-3x", "1-3x0", "1-3x-1", "1,,2", "1.5", "1-2-3", "x2",
                           "1x", "1-3x2x2", "+1", "99999999999999999999"}) {
    EXPECT_FALSE(FrameRange::parse(text).ok()) << text;
  }
  EXPECT_THAT(FrameRange::parse("9-3").error().message, HasSubstr("backwards; write 3-9"));
}

TEST(FrameRange, IsBounded) {
  EXPECT_FALSE(FrameRange::parse("1-1000000000").ok());
  EXPECT_THAT(FrameRange::parse("0-9000000").error().message, HasSubstr("more than 1000000 frames"));
  EXPECT_THAT(FrameRange::parse("0-900000,1000000-1900000").error().message, HasSubstr("more than"));
  EXPECT_EQ(FrameRange::parse("0-9000000x10")->count(), 900001u);
}

TEST(FrameRange, KnowsItsFrames) {
  const FrameRange range = *FrameRange::parse("10-20x5,40");
  EXPECT_EQ(range.first(), 10);
  EXPECT_EQ(range.last(), 40);
  EXPECT_EQ(range.count(), 4u);
  EXPECT_TRUE(range.contains(15));
  EXPECT_FALSE(range.contains(16));
}

} // namespace
} // namespace wry::shots
