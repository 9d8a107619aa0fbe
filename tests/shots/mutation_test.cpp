#include "tests/shots/mutation_support.h"

#include <gtest/gtest.h>

namespace wry::shots {
namespace {

TEST(Mutation, ThousandsOfBrokenShotsAreErrorsWithLineAndKey) {
  const MutationCounts counts = load_mutations(1, 3000);
  EXPECT_EQ(counts.accepted + counts.refused + counts.syntax, 3000);
  EXPECT_GT(counts.refused, 500) << "most have to get past the TOML parser";
  EXPECT_GT(counts.accepted, 50);
  EXPECT_GT(counts.syntax, 300);
}

TEST(Mutation, BrokenOverridesAreErrorsThatSaySet) {
  const MutationCounts counts = set_mutations(1, 2000);
  EXPECT_EQ(counts.accepted + counts.refused + counts.syntax, 2000);
  EXPECT_GT(counts.refused, 500);
  EXPECT_GT(counts.accepted, 20);
}

} // namespace
} // namespace wry::shots
