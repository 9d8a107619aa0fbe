#include "render/process_pool.h"

#include <csignal>
#include <set>

#include <gmock/gmock.h>
#include <unistd.h>

namespace wry::render {
namespace {

PooledWork work_of(int count, int processes, std::function<Status(int)> one) {
  PooledWork work;
  work.count = count;
  work.processes = processes;
  work.prepare = [one]() -> Result<std::function<Status(int)>> { return one; };
  return work;
}

TEST(ProcessPool, DoesEveryIndexOnce) {
  std::multiset<int> done;
  PooledWork work = work_of(37, 3, [](int) { return Status(); });
  work.done = [&](int index) { done.insert(index); };
  ASSERT_TRUE(run_in_processes(work).ok());
  EXPECT_EQ(done.size(), 37U);
  EXPECT_EQ(std::set<int>(done.begin(), done.end()).size(), 37U);
}

TEST(ProcessPool, AnswersWithTheErrorOfAChild) {
  const Status status = run_in_processes(work_of(8, 2, [](int index) -> Status {
    if (index == 3)
      return make_error(ErrorCode::missing_input, "frame {} is not there", index);
    return {};
  }));
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::missing_input);
  EXPECT_EQ(status.error().message, "frame 3 is not there");
}

TEST(ProcessPool, NoticesACrash) {
  const Status status = run_in_processes(work_of(4, 2, [](int index) -> Status {
    if (index == 1)
      ::raise(SIGKILL);
    return {};
  }));
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::out_of_memory);
}

TEST(ProcessPool, StopsWhenAsked) {
  int done = 0;
  PooledWork work = work_of(1000, 1, [](int) {
    ::usleep(2000);
    return Status();
  });
  work.done = [&](int) { ++done; };
  work.should_stop = [&] { return done >= 5; };
  const Status status = run_in_processes(work);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::stopped);
  EXPECT_LT(done, 100);
}

} // namespace
} // namespace wry::render
