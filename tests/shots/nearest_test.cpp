#include "shots/nearest.h"

#include <gtest/gtest.h>

namespace wry::shots {
namespace {

TEST(Nearest, CountsEditsInHalves) {
  EXPECT_EQ(half_edits("density", "density"), 0);
  EXPECT_EQ(half_edits("denisty", "density"), 2) << "a swap is one edit";
  EXPECT_EQ(half_edits("densit", "density"), 2);
  EXPECT_EQ(half_edits("Density", "density"), 1) << "case is half an edit";
  EXPECT_EQ(half_edits("", "abc"), 6);
  EXPECT_EQ(half_edits("kitten", "sitting"), 6);
}

TEST(Nearest, FindsWhatWasMeantOrNothing) {
  const std::vector<std::string> keys{"density", "model", "length_scale", "up"};
  EXPECT_EQ(nearest("lenght_scale", keys), "length_scale");
  EXPECT_EQ(nearest("modle", keys), "model");
  EXPECT_EQ(nearest("viscosity", keys), "");
  EXPECT_EQ(nearest("xy", keys), "") << "every letter wrong is no likeness";
  EXPECT_EQ(nearest(std::string(100'000, 'a'), keys), "");
}

TEST(Nearest, SuggestionsListTheKeysWhenNothingIsNear) {
  EXPECT_EQ(suggestion("modle", {"model"}), "; did you mean 'model'?");
  EXPECT_EQ(suggestion("qqqqqq", {"a", "b"}), "; known: a, b");
  EXPECT_EQ(suggestion("q", {}), "");
}

} // namespace
} // namespace wry::shots
