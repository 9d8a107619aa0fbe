#include "tests/shots/mutation_support.h"

#include <gtest/gtest.h>

namespace wry::shots {
namespace {

TEST(Mutation, TensOfThousandsOfBrokenShotsAreErrorsWithLineAndKey) {
  for (std::uint64_t seed = 2; seed < 12; ++seed) {
    const MutationCounts counts = load_mutations(seed, 5000);
    EXPECT_EQ(counts.accepted + counts.refused + counts.syntax, 5000) << "seed " << seed;
    EXPECT_GT(counts.refused, 1000) << "seed " << seed;
  }
}

} // namespace
} // namespace wry::shots
