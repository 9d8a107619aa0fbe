#include <cerrno>
#include <csignal>
#include <fstream>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "pipeline/cache/checkpoints.h"
#include "pipeline/cache/frame_cache.h"
#include "tests/pipeline/cache_support.h"

namespace wry::pipeline {

using namespace testing;

namespace {

template <class Body> int in_child(const Body& body) {
  const pid_t child = ::fork();
  if (child == 0)
    ::_exit(body());
  int outcome = 0;
  ::waitpid(child, &outcome, 0);
  return WIFEXITED(outcome) ? WEXITSTATUS(outcome) : 128 + WTERMSIG(outcome);
}

/// Fails the nth step of writing, counted from 1, with ENOSPC; counts all.
struct NthStepFails {
  int steps = 0;
  int failing = 0;
  int error_number = ENOSPC;
  FaultHook hook() {
    return [this](FileStep, const std::filesystem::path&) { return ++steps == failing ? error_number : 0; };
  }
};

/// Every frame that the cache names is whole and right.
void expect_sound(const std::filesystem::path& frames) {
  const Result<FolderReport> report = check_folder(frames);
  ASSERT_TRUE(report.ok()) << report.error().message;
  for (const FolderFinding& finding : report->findings)
    EXPECT_FALSE(is_damage(finding.kind)) << finding.message;
  const Result<FrameCache> cache = FrameCache::open_to_read(frames, "k");
  ASSERT_TRUE(cache.ok()) << cache.error().message;
  for (const CachedFrame& cached : cache->frames()) {
    const Result<Frame> frame = cache->read_frame(cached.number);
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    EXPECT_TRUE(is_made_frame(*frame, cached.number));
  }
}

} // namespace

class FailingStep : public ::testing::TestWithParam<int> {};

TEST_P(FailingStep, IsAClearErrorAtEveryStepAndTheNextTryWorks) {
  int failing = 1;
  for (bool failed_once = true; failed_once; ++failing) {
    TemporaryFolder folder;
    const std::filesystem::path frames = folder.path() / "frames";
    NthStepFails faults;
    faults.error_number = GetParam();
    Result<FrameCache> cache = FrameCache::open_to_write(frames, {"k", Compression::none, faults.hook()});
    ASSERT_TRUE(cache.ok());
    faults.failing = failing;
    failed_once = false;
    // The second write of frame 2 replaces it by another.
    int vertices = 400;
    for (const int number : {1, 2, 2, 3}) {
      const Status written = cache->write_frame(make_frame(number, ++vertices));
      if (written.ok())
        continue;
      failed_once = true;
      EXPECT_NE(written.error().message.find("frames"), std::string::npos) << written.error().message;
      EXPECT_EQ(written.error().code, GetParam() == EIO ? ErrorCode::io : ErrorCode::cannot_write);
      expect_sound(frames);
      const Status again = cache->write_frame(make_frame(number, vertices));
      ASSERT_TRUE(again.ok()) << again.error().message;
    }
    EXPECT_EQ(cache->frames().size(), 3u);
    expect_sound(frames);
  }
  EXPECT_GT(failing, 20) << "a frame has more steps than that";
}

INSTANTIATE_TEST_SUITE_P(Kinds, FailingStep, ::testing::Values(ENOSPC, EIO, EROFS));

TEST(FullDisk, IsNoticedAndTheRunGoesOnWhenThereIsSpaceAgain) {
  TemporaryFolder folder;
  const std::filesystem::path frames = folder.path() / "frames";
  const int code = in_child([&] {
    // A limit on the size of files fails in the middle of the bytes, as a full disk does.
    ::signal(SIGXFSZ, SIG_IGN);
    Result<FrameCache> cache = FrameCache::open_to_write(frames, {"k", Compression::none, {}});
    if (!cache || !cache->write_frame(make_frame(1, 1000)))
      return 1;
    const rlimit limit = {20'000, 20'000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    const Status written = cache->write_frame(make_frame(2, 1000));
    return !written && written.error().code == ErrorCode::cannot_write && !cache->has_frame(2) ? 42 : 2;
  });
  EXPECT_EQ(code, 42);
  expect_sound(frames);
  Result<FrameCache> cache = FrameCache::open_to_write(frames, {"k", Compression::none, {}});
  ASSERT_TRUE(cache->write_frame(make_frame(2, 1000)).ok());
  EXPECT_EQ(cache->frames().size(), 2u);
  expect_sound(frames);
}

TEST(FullDisk, OfARealFileSystemIsNoticed) {
  if (::geteuid() != 0)
    GTEST_SKIP() << "only root can mount a small file system; the other tests inject the same errors";
  TemporaryFolder folder;
  const std::filesystem::path disk = folder.path() / "disk";
  std::filesystem::create_directory(disk);
  // In a mount namespace of its own, so that nothing is left mounted whatever happens.
  const int code = in_child([&] {
    if (::unshare(CLONE_NEWNS) < 0 || ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) < 0 ||
        ::mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=400k") < 0)
      return 77;
    Result<FrameCache> cache = FrameCache::open_to_write(disk / "frames", {"k", Compression::none, {}});
    int written = 0;
    Status last;
    for (int number = 1; number <= 40 && last.ok(); ++number, ++written)
      last = cache->write_frame(make_frame(number, 1000));
    if (last.ok() || last.error().code != ErrorCode::cannot_write || cache->frames().empty())
      return 2;
    if (last.error().message.find("free") == std::string::npos)
      return 3;
    for (const CachedFrame& cached : cache->frames()) {
      const Result<Frame> frame = cache->read_frame(cached.number);
      if (!frame || !same_bits(*frame, make_frame(cached.number, 1000)))
        return 4;
    }
    if (::mount("tmpfs", disk.c_str(), "tmpfs", MS_REMOUNT, "size=8M") < 0)
      return 77;
    return cache->write_frame(make_frame(written, 1000)) ? 42 : 5;
  });
  if (code == 77)
    GTEST_SKIP() << "this machine does not let root mount";
  EXPECT_EQ(code, 42);
}

TEST(UnwritableFolder, IsFoundBeforeAnythingIsSimulated) {
  TemporaryFolder folder;
  spoil(folder.path() / "file", "in the way");
  const Result<FrameCache> below_file = FrameCache::open_to_write(folder.path() / "file" / "frames", {"k", {}, {}});
  ASSERT_FALSE(below_file.ok());
  EXPECT_EQ(below_file.error().code, ErrorCode::cannot_write);
  const std::filesystem::path locked = folder.path() / "locked";
  std::filesystem::create_directory(locked);
  std::filesystem::permissions(locked, std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  const int code = in_child([&] {
    // Rights mean nothing to root.
    if (::geteuid() == 0 && (::chmod(folder.path().c_str(), 0755) < 0 || ::setuid(65534) < 0))
      return 1;
    const Status ready = prepare_folder(locked);
    const bool says_what_to_do = !ready && ready.error().message.find("--out") != std::string::npos;
    return says_what_to_do && ready.error().code == ErrorCode::cannot_write ? 42 : 2;
  });
  EXPECT_EQ(code, 42);
}

TEST(VanishedFolder, IsAClearErrorAndNoCrash) {
  TemporaryFolder folder;
  const std::filesystem::path frames = folder.path() / "frames";
  Result<FrameCache> cache = FrameCache::open_to_write(frames, {"k", Compression::none, {}});
  ASSERT_TRUE(cache->write_frame(make_frame(1, 10)).ok());
  std::filesystem::remove_all(frames);
  const Status written = cache->write_frame(make_frame(2, 10));
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().code, ErrorCode::cannot_write);
  EXPECT_NE(written.error().message.find("not there"), std::string::npos) << written.error().message;
  EXPECT_FALSE(cache->read_frame(1).ok());
}

TEST(OutOfMemory, IsItsOwnErrorAndLeavesNothing) {
  TemporaryFolder folder;
  const std::filesystem::path frames = folder.path() / "frames";
  const Frame frame = make_frame(1, 2'000'000);
  const int code = in_child([&] {
    Result<FrameCache> cache = FrameCache::open_to_write(frames, {"k", Compression::none, {}});
    if (!cache)
      return 1;
    std::ifstream status("/proc/self/statm");
    rlim_t pages = 0;
    status >> pages;
    const rlim_t page = static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
    bool failed_cleanly = true;
    for (const rlim_t spare_mb : {4, 20, 40, 60, 80, 100, 130, 160}) {
      const rlimit limit = {pages * page + (spare_mb << 20), RLIM_INFINITY};
      ::setrlimit(RLIMIT_AS, &limit);
      const Status written = cache->write_frame(frame);
      failed_cleanly = failed_cleanly && (written.ok() || written.error().code == ErrorCode::out_of_memory);
      if (!written.ok())
        failed_cleanly = failed_cleanly && !cache->has_frame(1);
    }
    return failed_cleanly ? 42 : 2;
  });
  EXPECT_EQ(code, 42);
  expect_sound(frames);
}

TEST(ThousandsOfFrames, DoNotGrowTheProcess) {
  TemporaryFolder folder;
  Result<FrameCache> cache = FrameCache::open_to_write(folder.path() / "frames", {"k", Compression::none, {}});
  const auto resident_kb = [] {
    std::ifstream statm("/proc/self/statm");
    long total = 0;
    long resident = 0;
    statm >> total >> resident;
    return resident * (::sysconf(_SC_PAGESIZE) / 1024);
  };
  const auto write_and_read = [&](int number) {
    ASSERT_TRUE(cache->write_frame(make_frame(number, 2000)).ok());
    ASSERT_TRUE(cache->read_frame(number).ok());
  };
  for (int i = 0; i < 100; ++i)
    write_and_read(i % 10);
  const long before = resident_kb();
  for (int i = 0; i < 2000; ++i)
    write_and_read(i % 10);
  EXPECT_LT(resident_kb() - before, 1024) << "1 MB over 2000 frames of 100 kB";
}

} // namespace wry::pipeline
