#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/run/lock.h"
#include "tests/pipeline/cache_support.h"

namespace wry::pipeline {

using namespace testing;

namespace {

/// Runs `body` in a child process that leaves with what it returns.
template <class Body> pid_t in_child(const Body& body) {
  const pid_t child = ::fork();
  if (child == 0)
    ::_exit(body());
  return child;
}

int exit_code(pid_t child) {
  int outcome = 0;
  ::waitpid(child, &outcome, 0);
  return WIFEXITED(outcome) ? WEXITSTATUS(outcome) : 128 + WTERMSIG(outcome);
}

/// A lock file as a holder elsewhere would have left it.
std::string record(const LockHolder& holder, unsigned long long count) {
  return fmt::format("wry-lock-1 host {} machine {} boot {} namespace {} pid {} start {} count {:020}\n", holder.host,
                     holder.machine, holder.boot, holder.pid_namespace, holder.pid, holder.start, count);
}

/// As holders do it: in place, so that no reader sees half a record.
void overwrite(const std::filesystem::path& path, const std::string& bytes) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  EXPECT_EQ(::pwrite(file, bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
  ::close(file);
}

constexpr FolderLock::Settings QUICK = {std::chrono::milliseconds(20), std::chrono::milliseconds(400)};

} // namespace

TEST(FolderLock, SecondRunIsToldWhoHoldsIt) {
  TemporaryFolder folder;
  const Result<FolderLock> first = FolderLock::acquire(folder.path());
  ASSERT_TRUE(first.ok()) << first.error().message;
  EXPECT_EQ(first->recovered_from(), "");
  const Result<FolderLock> second = FolderLock::acquire(folder.path());
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::cannot_write);
  EXPECT_NE(second.error().message.find(fmt::format("process {} on {}", ::getpid(), this_process().host)),
            std::string::npos)
      << second.error().message;
}

TEST(FolderLock, IsGoneWithItsHolderAndLeavesNothing) {
  TemporaryFolder folder;
  { ASSERT_TRUE(FolderLock::acquire(folder.path()).ok()); }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  const Result<FolderLock> again = FolderLock::acquire(folder.path());
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again->recovered_from(), "");
}

TEST(FolderLock, OfAKilledProcessIsRecovered) {
  TemporaryFolder folder;
  int ready[2];
  ASSERT_EQ(::pipe(ready), 0);
  const pid_t child = in_child([&] {
    const Result<FolderLock> lock = FolderLock::acquire(folder.path());
    if (::write(ready[1], lock.ok() ? "y" : "n", 1) != 1)
      return 1;
    ::pause();
    return 0;
  });
  char answer = 0;
  ASSERT_EQ(::read(ready[0], &answer, 1), 1);
  ASSERT_EQ(answer, 'y');
  EXPECT_FALSE(FolderLock::acquire(folder.path()).ok());
  ::kill(child, SIGKILL);
  exit_code(child);
  ASSERT_TRUE(std::filesystem::exists(folder.path() / "lock"));
  const Result<FolderLock> recovered = FolderLock::acquire(folder.path());
  ASSERT_TRUE(recovered.ok()) << recovered.error().message;
  EXPECT_NE(recovered->recovered_from().find(fmt::format("process {}", child)), std::string::npos)
      << recovered->recovered_from();
  ::close(ready[0]);
  ::close(ready[1]);
}

TEST(FolderLock, OfThisMachineBeforeARebootIsRecovered) {
  TemporaryFolder folder;
  LockHolder before = this_process();
  before.boot = "00000000-1111-2222-3333-444444444444";
  before.pid = 1;
  if (before.machine == "-")
    before.machine = "0123456789abcdef";
  spoil(folder.path() / "lock", record(before, 12));
  const Result<FolderLock> lock = FolderLock::acquire(folder.path(), QUICK);
  ASSERT_TRUE(lock.ok()) << lock.error().message;
  EXPECT_NE(lock->recovered_from(), "");
}

TEST(FolderLock, OfAProcessWhoseNumberWasGivenAgainIsRecovered) {
  TemporaryFolder folder;
  LockHolder other = this_process();
  other.start += 1;
  spoil(folder.path() / "lock", record(other, 3));
  EXPECT_TRUE(FolderLock::acquire(folder.path(), QUICK).ok());
}

TEST(FolderLock, OfALivingProcessIsRespectedEvenWithoutItsKernelLock) {
  TemporaryFolder folder;
  spoil(folder.path() / "lock", record(this_process(), 3));
  const Result<FolderLock> lock = FolderLock::acquire(folder.path(), QUICK);
  ASSERT_FALSE(lock.ok());
  EXPECT_EQ(lock.error().code, ErrorCode::cannot_write);
}

TEST(FolderLock, OfAnotherMachineHoldsAsLongAsItsCountMoves) {
  TemporaryFolder folder;
  const LockHolder other = {"farm07", "feedfacefeedface", "99999999-0000-0000-0000-000000000000", "pid:[1]", 4711, 99};
  const std::filesystem::path path = folder.path() / "lock";
  spoil(path, record(other, 1));
  std::jthread living([&](std::stop_token stop) {
    for (unsigned long long count = 2; !stop.stop_requested(); ++count) {
      overwrite(path, record(other, count));
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
  const Result<FolderLock> held = FolderLock::acquire(folder.path(), QUICK);
  living = {};
  ASSERT_FALSE(held.ok());
  EXPECT_NE(held.error().message.find("process 4711 on farm07"), std::string::npos) << held.error().message;
  EXPECT_NE(held.error().message.find("remove"), std::string::npos) << held.error().message;
  const Result<FolderLock> taken = FolderLock::acquire(folder.path(), QUICK);
  ASSERT_TRUE(taken.ok()) << taken.error().message;
}

TEST(FolderLock, TornLockFilesAreStale) {
  TemporaryFolder folder;
  spoil(folder.path() / "lock", "wry-lock-1 host farm0");
  EXPECT_TRUE(FolderLock::acquire(folder.path(), QUICK).ok());
}

TEST(FolderLock, CountsUpWhileHeld) {
  TemporaryFolder folder;
  const Result<FolderLock> lock = FolderLock::acquire(folder.path(), QUICK);
  ASSERT_TRUE(lock.ok());
  const std::string before = contents(folder.path() / "lock");
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_NE(before, contents(folder.path() / "lock"));
  EXPECT_EQ(before.size(), contents(folder.path() / "lock").size());
}

TEST(FolderLock, IsNotRemovedByAForkedChild) {
  TemporaryFolder folder;
  const Result<FolderLock> lock = FolderLock::acquire(folder.path());
  ASSERT_TRUE(lock.ok());
  EXPECT_EQ(exit_code(in_child([&] {
              const Result<FolderLock> inner = FolderLock::acquire(folder.path());
              return inner.ok() ? 1 : 0;
            })),
            0);
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "lock"));
}

/// Many processes race; each winner shows, by an exclusive file, that it is alone, and half of the winners are killed
/// while they hold the lock.
TEST(FolderLock, ExactlyOneOfManyRacingProcessesHasIt) {
  TemporaryFolder folder;
  const std::filesystem::path alone = folder.path() / "alone";
  constexpr int PROCESSES = 8;
  constexpr int ROUNDS = 40;
  int winners = 0;
  for (int round = 0; round < ROUNDS; ++round) {
    std::filesystem::remove(alone);
    int gate[2];
    ASSERT_EQ(::pipe(gate), 0);
    std::vector<pid_t> children;
    for (int i = 0; i < PROCESSES; ++i) {
      children.push_back(in_child([&] {
        // All start when the parent closes the gate.
        char nothing = 0;
        ::close(gate[1]);
        if (::read(gate[0], &nothing, 1) != 0)
          return 1;
        const Result<FolderLock> lock = FolderLock::acquire(folder.path());
        if (!lock)
          return lock.error().code == ErrorCode::cannot_write ? 10 : 2;
        const int file = ::open(alone.c_str(), O_CREAT | O_EXCL | O_WRONLY, 0600);
        if (file < 0)
          return 3; // somebody else holds it too
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        std::filesystem::remove(alone);
        if (i % 2 == 0)
          ::kill(::getpid(), SIGKILL);
        return 0;
      }));
    }
    ::close(gate[0]);
    ::close(gate[1]);
    int won_now = 0;
    for (const pid_t child : children) {
      const int code = exit_code(child);
      won_now += code == 0 || code == 128 + SIGKILL;
      EXPECT_TRUE(code == 0 || code == 10 || code == 128 + SIGKILL) << code;
    }
    EXPECT_GE(won_now, 1) << "nobody had the lock in round " << round;
    winners += won_now;
  }
  EXPECT_GE(winners, ROUNDS);
}

} // namespace wry::pipeline
