#include <csignal>
#include <sys/resource.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include <gtest/gtest.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/run/signals.h"
#include "tests/pipeline/cache_support.h"

namespace wry::pipeline {

namespace {

template <class Body> int in_child(const Body& body) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(STDERR_FILENO);
    ::_exit(body());
  }
  int outcome = 0;
  ::waitpid(child, &outcome, 0);
  return WIFEXITED(outcome) ? WEXITSTATUS(outcome) : 128 + WTERMSIG(outcome);
}

} // namespace

class StopSignals : public ::testing::TestWithParam<int> {};

TEST_P(StopSignals, FirstAsksForAStop) {
  const int code = in_child([] {
    if (!install_stop_signals() || stop_requested())
      return 1;
    ::raise(GetParam());
    const Error error = stopped_by_signal("frame 3 is the last");
    const bool is_named = error.message.find(GetParam() == SIGINT ? "SIGINT" : "SIGTERM") != std::string::npos;
    return stop_requested() && error.code == ErrorCode::stopped && is_named ? 42 : 2;
  });
  EXPECT_EQ(code, 42);
}

TEST_P(StopSignals, SecondLeavesAtOnceWith75) {
  const int code = in_child([] {
    if (!install_stop_signals())
      return 1;
    ::raise(GetParam());
    ::raise(SIGTERM);
    return 2;
  });
  EXPECT_EQ(code, 75);
}

INSTANTIATE_TEST_SUITE_P(Both, StopSignals, ::testing::Values(SIGTERM, SIGINT));

TEST(StopSignals, AFileTooLargeForItsLimitIsAnErrorNotADeath) {
  testing::TemporaryFolder folder;
  const int code = in_child([&] {
    if (!install_stop_signals())
      return 1;
    const rlimit limit = {100'000, 100'000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    const Status written = write_file_atomically(folder.path() / "large", std::string(200'000, 'x'));
    return !written && written.error().code == ErrorCode::cannot_write ? 42 : 2;
  });
  EXPECT_EQ(code, 42);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

} // namespace wry::pipeline
