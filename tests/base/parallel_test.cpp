#include "sim/base/parallel.h"

#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>
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

TEST(Parallel, LoopsWithinLoopsAndFromSeveralCallersVisitEveryIndexOnce) {
  const Threads threads(2);
  std::vector<int> visits(64 * 64, 0);
  const auto visit_rows = [&](std::size_t first_row) {
    threads.for_each(32, 1, [&](std::size_t row) {
      threads.for_each(64, 5, [&](std::size_t column) { ++visits[64 * (first_row + row) + column]; });
    });
  };
  std::thread other(visit_rows, 32);
  visit_rows(0);
  other.join();
  EXPECT_EQ(visits, std::vector<int>(64 * 64, 1));
}

TEST(Parallel, ManyShortLoopsInARowEachEndBeforeTheNext) {
  const Threads threads(2);
  std::vector<long> steps(16, 0);
  for (long loop = 0; loop < 20000; ++loop) {
    if (loop % 4000 == 0) // long enough for the others to fall asleep
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    threads.for_each(steps.size(), 1, [&](std::size_t i) { steps[i] = steps[i] == loop ? loop + 1 : -1; });
  }
  EXPECT_EQ(steps, std::vector<long>(16, 20000));
}

TEST(Parallel, GoesOnAfterAnException) {
  const Threads threads(2);
  for (int round = 0; round < 100; ++round) {
    EXPECT_THROW(threads.for_each(8, 1, [](std::size_t) { throw std::runtime_error("all"); }), std::runtime_error);
    std::vector<int> visits(8, 0);
    threads.for_each(visits.size(), 1, [&](std::size_t i) { ++visits[i]; });
    ASSERT_EQ(visits, std::vector<int>(8, 1));
  }
}

} // namespace
} // namespace wry
