#include <atomic>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "pipeline/run/watchdog.h"

namespace wry::pipeline {

namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

} // namespace

TEST(Watchdog, EndsAHangWithinTwiceItsBudget) {
  std::atomic<bool> acted = false;
  std::string said;
  const Clock::time_point start = Clock::now();
  {
    Watchdog watchdog({200ms, "bunny", [&](const std::string& message) {
                         said = message;
                         acted = true;
                       }});
    watchdog.progress("step 12");
    while (!acted && Clock::now() - start < 5s)
      std::this_thread::sleep_for(1ms);
  }
  ASSERT_TRUE(acted);
  EXPECT_GE(Clock::now() - start, 200ms);
  EXPECT_LE(Clock::now() - start, 400ms);
  EXPECT_NE(said.find("bunny"), std::string::npos) << said;
  EXPECT_NE(said.find("step 12"), std::string::npos) << said;
}

TEST(Watchdog, LeavesARunThatGoesOnAlone) {
  std::atomic<int> acted = 0;
  {
    Watchdog watchdog({300ms, "", [&](const std::string&) { ++acted; }});
    for (int i = 0; i < 60; ++i) {
      std::this_thread::sleep_for(10ms);
      watchdog.progress("a step");
    }
  }
  EXPECT_EQ(acted, 0);
}

TEST(Watchdog, LeavesTheProcessWith70) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(STDERR_FILENO);
    Watchdog watchdog({50ms, "bunny", {}});
    for (;;)
      ::pause();
  }
  int outcome = 0;
  ::waitpid(child, &outcome, 0);
  ASSERT_TRUE(WIFEXITED(outcome));
  EXPECT_EQ(WEXITSTATUS(outcome), 70);
}

} // namespace wry::pipeline
