#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>

#include <sys/wait.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cli/program_support.h"
#include "tests/cli/slurm_support.h"

/// The table "Promises -> tests" where whole programs are needed; the rest is tested beside the part that keeps each.
namespace wry::cli_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Promise : public testing::Test {
protected:
  Promise() { write_text(m_folder.path() / "bar.toml", small_shot()); }
  Outcome simulate(const std::string& out, std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {"simulate", "bar.toml", "--out", out, "--frames", "1-4", "--isa", "sse4"};
    words.insert(words.end(), more.begin(), more.end());
    return run_wry(words, m_folder.path());
  }
  /// The program under a limit that a shell sets; exit code, and its words in m_folder/words.
  int under(const std::string& limit, const std::string& out, const std::string& more = {}) const {
    const std::string command = "cd " + m_folder.path().string() + " && " + limit + " " + WRY_PROGRAM +
                                " simulate bar.toml --isa sse4 --threads 1 --frames 1-4 --out " + out + " " + more +
                                " > words 2>&1";
    const int status = std::system(("sh -c '" + command + "'").c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  std::string words() const { return read_text(m_folder.path() / "words"); }
  const TemporaryFolder m_folder;
};

TEST_F(Promise, OutOfMemoryHasItsOwnMessageAndNothingIsHalfWritten) {
  ASSERT_EQ(simulate("whole").exit_code, 0);
  int ran_out = 0;
  // Up to about 330 MiB go to libraries that start before main() and do not all end well; that is not tested here.
  for (const int mebibytes : {345, 360, 380, 400, 430}) {
    const int code =
        under("timeout -s KILL 60 prlimit --as=" + std::to_string(mebibytes * 1048576L), "limited", "--ignore-limits");
    if (code == 127 || code == 126)
      continue; // not even the loader fits
    EXPECT_TRUE(code == 0 || code == 71) << mebibytes << " MiB: " << code << ": " << words();
    ran_out += code == 71 ? 1 : 0;
    if (code == 71) {
      EXPECT_THAT(words(), HasSubstr("memory"));
    }
    ASSERT_EQ(simulate("limited").exit_code, 0) << "what was left can be gone on from";
    EXPECT_EQ(frame_hashes(m_folder.path() / "limited"), frame_hashes(m_folder.path() / "whole"));
    fs::remove_all(m_folder.path() / "limited");
  }
  RecordProperty("limits_that_were_too_small", ran_out);
}

TEST_F(Promise, WhatNeedsMoreThanThereIsIsRefusedUnlessToldToGoOn) {
  // Planning it takes a tenth of what simulating it would. The limit leaves room for the libraries of a whole build
  // (330 MiB), and is less than what a bare one needs, too.
  EXPECT_EQ(under("prlimit --as=" + std::to_string(470 * 1048576L), "a", "--set body.bar.resolution=0.006"), 71)
      << words();
  EXPECT_THAT(words(), HasSubstr("of memory, but only"));
  EXPECT_THAT(words(), HasSubstr("ulimit -v"));
  EXPECT_THAT(words(), HasSubstr("body.bar.resolution"));
  EXPECT_FALSE(fs::exists(m_folder.path() / "a/frames/0001.h5")) << "before anything is simulated";
  EXPECT_EQ(under("prlimit --as=" + std::to_string(470 * 1048576L), "a"), 0)
      << "what needs little runs there: " << words();
}

TEST_F(Promise, AFullDiskIsSaidSoAndTheRunGoesOnWhenThereIsRoom) {
  const fs::path disk = m_folder.path() / "disk";
  fs::create_directories(disk);
  if (!shell("mount -t tmpfs -o size=48k none " + disk.string()))
    GTEST_SKIP() << "may not mount";
  ASSERT_EQ(simulate("whole").exit_code, 0);
  const auto on_disk = [&](const char* verb, std::vector<std::string> more) {
    more.insert(more.begin(), {verb, "bar.toml", "--out", "disk/o", "--frames", "1-4", "--isa", "sse4"});
    return run_wry(more, m_folder.path());
  };
  const Outcome refused = on_disk("simulate", {});
  EXPECT_EQ(refused.exit_code, 73) << refused.err;
  EXPECT_THAT(refused.err, HasSubstr("of disk, but only"));
  EXPECT_THAT(on_disk("plan", {}).out, HasSubstr("as it stands it would be refused: bar: needs about"));
  const Outcome full = on_disk("simulate", {"--ignore-limits"});
  EXPECT_TRUE(full.exit_code == 73 || full.exit_code == 74) << full.exit_code << full.err;
  EXPECT_THAT(full.err, testing::AnyOf(HasSubstr("free"), HasSubstr("space"), HasSubstr("room"))) << full.err;
  shell("mount -o remount,size=50m " + disk.string());
  const Outcome again = on_disk("simulate", {});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(frame_hashes(disk / "o"), frame_hashes(m_folder.path() / "whole"));
  shell("umount " + disk.string());
}

TEST_F(Promise, AnUnwritableOutputIsFoundBeforeAnythingIsSimulated) {
  write_text(m_folder.path() / "file", "in the way");
  const auto began = std::chrono::steady_clock::now();
  const Outcome outcome =
      run_wry({"simulate", "bar.toml", "--out", "file/out", "--frames", "1-100000"}, m_folder.path());
  EXPECT_EQ(outcome.exit_code, 73) << outcome.err;
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(5));
}

TEST_F(Promise, AnEnormousMeshIsRefusedBeforeItIsMade) {
  const auto began = std::chrono::steady_clock::now();
  const Outcome outcome = simulate("o", {"--set", "body.bar.resolution=0.0003"});
  EXPECT_TRUE(outcome.exit_code == 71 || outcome.exit_code == 65) << outcome.exit_code << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("use a longer edge"));
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(5));
}

TEST_F(Promise, AskedToStopItIsGoneWithinTwoSeconds) {
  int stopped = 0;
  for (const int after : {60, 150, 300}) {
    const auto began = std::chrono::steady_clock::now();
    const Outcome outcome = run_wry_and_signal({"simulate", "bar.toml", "--out", "o", "--frames", "1-2000", "--fresh"},
                                               m_folder.path(), SIGTERM, after);
    EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::milliseconds(after + 2000));
    stopped += outcome.exit_code == 75 ? 1 : 0;
  }
  EXPECT_GT(stopped, 0);
}

TEST_F(Promise, NoNameOfAShotLeadsOutOfTheOutputFolder) {
  for (const char* name : {"../evil", "/tmp/evil", "a/b", "..", "a\\nb"}) {
    std::string text = small_shot();
    text.replace(text.find("name = \"bar\""), 12, std::string("name = \"") + name + "\"");
    write_text(m_folder.path() / "evil.toml", text);
    const Outcome outcome = run_wry({"plan", "evil.toml"}, m_folder.path());
    EXPECT_EQ(outcome.exit_code, 65) << name << outcome.out;
  }
  EXPECT_EQ(
      run_wry({"simulate", "bar.toml", "--set", "render.views=[\"heat.../../../evil\"]", "--dry-run"}, m_folder.path())
          .exit_code,
      65);
}

TEST_F(Promise, EnormousRequestsEndAtOnce) {
  const auto began = std::chrono::steady_clock::now();
  for (const char* set :
       {"shot.frames=\"1-1000000000\"", "shot.frames=\"1-9999999999999999999\"", "render.samples=1000000000",
        "render.size=[1000000000, 1000000000]", "body.bar.cells=[1000000, 1000000, 1000000]"}) {
    const Outcome outcome = run_wry({"plan", "bar.toml", "--set", set}, m_folder.path());
    EXPECT_TRUE(outcome.exit_code == 65 || outcome.exit_code == 71) << set << ": " << outcome.exit_code << outcome.err;
  }
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(5));
}

TEST_F(Promise, ManyFramesDoNotLeak) {
  const char* asked = std::getenv("WRY_LEAK_FRAMES");
  const int frames = asked != nullptr ? std::atoi(asked) : 150;
  // A block of five tets that stands still: what grows is the program's own.
  const auto peak_of = [&](int last) {
    const std::string command = "cd " + m_folder.path().string() + " && " + WRY_PROGRAM +
                                " simulate bar.toml --fresh --quiet --threads 1 --out leak --set shot.fps=1000 "
                                "--set body.bar.resolution=0.1 --frames 1-" +
                                std::to_string(last) +
                                " & child=$!; peak=0; while kill -0 $child 2>/dev/null; do "
                                "now=$(awk '/VmHWM/ { print $2 }' /proc/$child/status 2>/dev/null); "
                                "[ -n \"$now\" ] && peak=$now; sleep 0.02; done; echo $peak > " +
                                m_folder.path().string() + "/peak";
    write_text(m_folder.path() / "leak.sh", command);
    std::system(("sh " + (m_folder.path() / "leak.sh").string()).c_str());
    return std::atof(read_text(m_folder.path() / "peak").c_str());
  };
  const double few = peak_of(frames / 3), many = peak_of(frames);
  ASSERT_GT(few, 1000.0);
  EXPECT_LT(many, 1.03 * few) << "KiB resident after " << frames / 3 << " and " << frames << " frames";
}

} // namespace
} // namespace wry::cli_test
