#include "sim/base/parallel.h"

#include <cmath>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace wry {
namespace {

double sum_of_reciprocals(int thread_count) {
  const Threads threads(thread_count);
  return threads.sum_chunks(100000, 128, [](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i)
      sum += 1.0 / (1.0 + static_cast<double>(i));
    return sum;
  });
}

TEST(Parallel, SumsAreTheSameBitsOnAnyNumberOfThreads) {
  const double one = sum_of_reciprocals(1);
  EXPECT_NEAR(one, std::log(100000.0) + 0.5772156649, 1e-4);
  for (const int count : {2, 3, 8})
    EXPECT_EQ(one, sum_of_reciprocals(count)) << count << " threads";
}

TEST(Parallel, EveryIndexIsVisitedOnce) {
  for (const int count : {1, 3}) {
    const Threads threads(count);
    std::vector<int> visits(1001, 0);
    threads.for_each(visits.size(), 17, [&](std::size_t i) { ++visits[i]; });
    EXPECT_EQ(visits, std::vector<int>(1001, 1));
  }
}

TEST(Parallel, ExceptionsReachTheCaller) {
  const Threads threads(2);
  EXPECT_THROW(threads.for_each(100, 1,
                                [](std::size_t i) {
                                  if (i == 57)
                                    throw std::runtime_error("57");
                                }),
               std::runtime_error);
}

} // namespace
} // namespace wry
