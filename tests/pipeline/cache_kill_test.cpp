#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <random>
#include <set>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "pipeline/cache/checkpoints.h"
#include "pipeline/cache/frame_cache.h"
#include "tests/pipeline/cache_support.h"

namespace wry::pipeline {

using namespace testing;

namespace {

constexpr int VERTICES = 3000;

/// How many kills; WRY_TEST_KILLS asks for more than the hundred or so of a normal run.
int kill_count() {
  const char* asked = std::getenv("WRY_TEST_KILLS");
  return asked == nullptr ? 120 : std::atoi(asked);
}

/// What a run does, without the physics: goes on from the last checkpoint and writes frames and checkpoints until
/// killed. Tells each finished frame through `told`.
[[noreturn]] void write_frames_for_ever(const std::filesystem::path& folder, int told) {
  Result<FrameCache> cache = FrameCache::open_to_write(folder / "frames", {"k", Compression::none, {}});
  Result<CheckpointStore> checkpoints = CheckpointStore::open(folder / "checkpoints", {"k", 0, {}});
  if (!cache || !checkpoints)
    ::_exit(3);
  if (!cache->has_static() && !cache->write_static(make_static()))
    ::_exit(4);
  const Result<CheckpointStore::Found> found = checkpoints->latest_at_or_before(1'000'000);
  if (!found || !found->warnings.empty())
    ::_exit(5);
  const int start = found->checkpoint ? found->checkpoint->frame : 0;
  if (found->checkpoint && !same_bits(found->checkpoint->state, make_state(start)))
    ::_exit(6);
  // Every third frame replaces one that is already there by another.
  for (int frame = start + 1;; ++frame) {
    const int number = frame % 3 == 0 ? frame - 2 : frame;
    if (!cache->write_frame(make_frame(number, VERTICES + frame % 3)))
      ::_exit(7);
    if (::write(told, &number, sizeof(number)) != sizeof(number))
      ::_exit(8);
    if (!checkpoints->write(make_state(frame), frame, frame / 24.0))
      ::_exit(9);
  }
}

/// The numbers that a killed child told before it died.
std::vector<int> told_numbers(int pipe) {
  std::vector<int> numbers;
  int number = 0;
  while (::read(pipe, &number, sizeof(number)) == static_cast<ssize_t>(sizeof(number)))
    numbers.push_back(number);
  return numbers;
}

/// Starts a writer, lets it finish `frames`, kills it `microseconds` later, and returns what it finished.
std::vector<int> kill_a_writer(const std::filesystem::path& folder, int frames, int microseconds) {
  int ends[2];
  EXPECT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
    write_frames_for_ever(folder, ends[1]);
  }
  ::close(ends[1]);
  std::vector<int> numbers;
  for (int number = 0; frames > 0 && ::read(ends[0], &number, sizeof(number)) == sizeof(number); --frames)
    numbers.push_back(number);
  ::usleep(static_cast<useconds_t>(microseconds));
  ::kill(child, SIGKILL);
  int outcome = 0;
  ::waitpid(child, &outcome, 0);
  EXPECT_TRUE(WIFSIGNALED(outcome)) << "the writer failed with " << WEXITSTATUS(outcome);
  const std::vector<int> rest = told_numbers(ends[0]);
  numbers.insert(numbers.end(), rest.begin(), rest.end());
  ::close(ends[0]);
  return numbers;
}

} // namespace

TEST(KilledWriter, LosesNothingThatItFinishedAndTearsNothing) {
  TemporaryFolder folder;
  std::mt19937 random(7);
  std::set<int> finished;
  int in_flight_leftovers = 0;
  for (int kill = 0; kill < kill_count(); ++kill) {
    const int before = std::uniform_int_distribution<int>(0, 4)(random);
    const int wait = std::uniform_int_distribution<int>(0, 4000)(random);
    const std::vector<int> told = kill_a_writer(folder.path(), before, wait);
    finished.insert(told.begin(), told.end());
    if (!std::filesystem::exists(folder.path() / "frames"))
      continue;
    const Result<FrameCache> cache = FrameCache::open_to_read(folder.path() / "frames", "k");
    ASSERT_TRUE(cache.ok()) << cache.error().message;
    std::size_t gone = 0;
    for (const int number : finished)
      gone += !cache->has_frame(number);
    // A frame that was just being replaced may be out of the manifest; everything else that was finished is in it.
    ASSERT_LE(gone, 1u) << "after kill " << kill;
    const Result<FolderReport> report = check_folder(folder.path() / "frames");
    ASSERT_TRUE(report.ok()) << report.error().message;
    for (const FolderFinding& finding : report->findings) {
      ASSERT_FALSE(is_damage(finding.kind)) << finding.message;
      ++in_flight_leftovers;
    }
    const std::vector<CachedFrame> frames = cache->frames();
    if (frames.empty())
      continue;
    const int last = frames.back().number;
    const Result<Frame> frame = cache->read_frame(last);
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    ASSERT_TRUE(is_made_frame(*frame, last));
    // What was being replaced is written again by the next run; count it as not finished until then.
    std::erase_if(finished, [&](int number) { return !cache->has_frame(number); });
  }
  EXPECT_GT(finished.size(), 20u) << "the writers must have got somewhere";
  EXPECT_GT(in_flight_leftovers, 0) << "some kills must have hit a write";
}

TEST(ConcurrentReader, NeverMeetsATornFrame) {
  TemporaryFolder folder;
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  if (child == 0)
    write_frames_for_ever(folder.path(), ends[1]);
  std::mt19937 random(3);
  int good = 0;
  Result<FrameCache> cache = make_error(ErrorCode::missing_input, "not yet");
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (good < 500 && std::chrono::steady_clock::now() < end) {
    if (!cache) {
      cache = FrameCache::open_to_read(folder.path() / "frames", "k");
      continue;
    }
    const Status refreshed = cache->refresh();
    ASSERT_TRUE(refreshed.ok()) << refreshed.error().message;
    const std::vector<CachedFrame> frames = cache->frames();
    if (frames.empty())
      continue;
    // The newest frames are those that may be replaced while they are read.
    const std::size_t back =
        std::uniform_int_distribution<std::size_t>(0, std::min<std::size_t>(3, frames.size() - 1))(random);
    const int number = frames[frames.size() - 1 - back].number;
    const Result<Frame> frame = cache->read_frame(number);
    // Between taking the old out of the manifest and naming the new, a frame is rightly not there.
    if (!frame && frame.error().code == ErrorCode::missing_input)
      continue;
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    ASSERT_TRUE(is_made_frame(*frame, number));
    ++good;
  }
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  ::close(ends[0]);
  ::close(ends[1]);
  EXPECT_EQ(good, 500);
}

} // namespace wry::pipeline
