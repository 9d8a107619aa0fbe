#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>

#include <sys/wait.h>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/report/csv_table.h"
#include "tests/cli/program_support.h"
#include "tests/cli/slurm_support.h"

namespace wry::cli_test {
namespace {

namespace fs = std::filesystem;

constexpr const char* SWEEP = "[sweep]\n\"material.soft.youngs_modulus\" = [2e4, 3e4, 4e4, 5e4]\n";

class SlurmLong : public testing::Test {
protected:
  void SetUp() override {
    if (!SlurmFarm::is_installed())
      GTEST_SKIP() << "needs root, slurm-wlm and munge";
    write_text(m_folder.path() / "bar.toml", small_shot() + SWEEP);
  }
  std::vector<std::string> arguments(const std::string& out, const std::string& engine) const {
    return {"sweep",  "bar.toml", "--out", out,    "--engine", engine,
            "--jobs", "4",        "--isa", "sse4", "--set",    "body.bar.resolution=0.02"};
  }
  std::vector<std::vector<std::string>> hashes(const std::string& out) const {
    std::vector<std::vector<std::string>> all;
    for (const auto& row : pipeline::read_csv_table(m_folder.path() / out / "sweep.csv").rows)
      all.push_back(frame_hashes(m_folder.path() / out / "wedges" / row.at(0)));
    return all;
  }
  /// Starts a sweep and returns at once.
  pid_t begin(const std::vector<std::string>& words) const {
    const pid_t child = fork();
    if (child != 0)
      return child;
    std::vector<char*> pointers = {const_cast<char*>(WRY_PROGRAM)};
    for (const std::string& word : words)
      pointers.push_back(const_cast<char*>(word.c_str()));
    pointers.push_back(nullptr);
    if (chdir(m_folder.path().c_str()) != 0)
      _exit(126);
    execv(pointers[0], pointers.data());
    _exit(127);
  }
  /// Until some wedge has frames on disk.
  void wait_for_frames(const std::string& out) const {
    for (int i = 0; i < 1000; ++i) {
      std::size_t frames = 0;
      std::error_code ignored;
      for (const fs::directory_entry& wedge : fs::directory_iterator(m_folder.path() / out / "wedges", ignored))
        frames += frame_hashes(wedge.path()).size();
      if (frames >= 4)
        return;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  const TemporaryFolder m_folder;
};

TEST_F(SlurmLong, ANodeKilledMidSweepLosesNothing) {
  ASSERT_EQ(run_wry(arguments("local", "local"), m_folder.path()).exit_code, 0);
  SlurmFarm farm(m_folder.path() / "farm");
  ASSERT_EQ(farm.problem(), "") << farm.logs();
  const pid_t sweep = begin(arguments("s", "slurm"));
  wait_for_frames("s");
  farm.kill_node("n1");
  // Slurm holds what it requeues back for two minutes; a test does not wait for that.
  int status = 0;
  for (int i = 0; i < 600 && waitpid(sweep, &status, WNOHANG) == 0; ++i) {
    shell("for job in $(squeue --noheader --states=PENDING --format=%A); do scontrol update JobId=$job StartTime=now; "
          "done");
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
  const Outcome again = run_wry(arguments("s", "slurm"), m_folder.path());
  EXPECT_EQ(again.exit_code, 0) << again.err << farm.logs();
  EXPECT_EQ(hashes("s"), hashes("local")) << "the same bits as without a farm and without a loss";
}

/// A shipped sweep of 24 wedges, made small.
struct ShippedSweep {
  std::string name;
  std::vector<std::string> sets;
};

class ShippedSweepLong : public SlurmLong, public testing::WithParamInterface<ShippedSweep> {
protected:
  std::vector<std::string> words(const std::string& out, const std::string& engine) const {
    std::vector<std::string> all = {"sweep",    std::string(WRY_SOURCE_DIR) + "/shots/" + GetParam().name + ".toml",
                                    "--out",    out,
                                    "--engine", engine,
                                    "--jobs",   "2",
                                    "--isa",    "sse4"};
    for (const std::string& set : GetParam().sets)
      all.insert(all.end(), {"--set", set});
    return all;
  }
  /// Exit codes: all wedges done, whether or not such coarse ones hold what is expected of fine ones.
  static bool is_done(const Outcome& outcome) { return outcome.exit_code == 0 || outcome.exit_code == 1; }
};

TEST_P(ShippedSweepLong, KilledAndResumedOnBothEnginesItsWedgesAreTheSame) {
  const Outcome whole = run_wry(words("whole", "local"), m_folder.path());
  ASSERT_TRUE(is_done(whole)) << whole.err;
  ASSERT_EQ(hashes("whole").size(), 24u);
  for (const std::vector<std::string>& frames : hashes("whole"))
    ASSERT_GE(frames.size(), 2u) << whole.err;

  const pid_t local = begin(words("local", "local"));
  wait_for_frames("local");
  kill(local, SIGKILL);
  waitpid(local, nullptr, 0);
  const Outcome resumed = run_wry(words("local", "local"), m_folder.path());
  EXPECT_TRUE(is_done(resumed)) << resumed.err;
  EXPECT_EQ(hashes("local"), hashes("whole"));

  SlurmFarm farm(m_folder.path() / "farm");
  ASSERT_EQ(farm.problem(), "") << farm.logs();
  const pid_t slurm = begin(words("slurm", "slurm"));
  wait_for_frames("slurm");
  farm.kill_node("n1");
  kill(slurm, SIGKILL);
  waitpid(slurm, nullptr, 0);
  shell("scancel --user=root");
  const Outcome again = run_wry(words("slurm", "slurm"), m_folder.path());
  EXPECT_TRUE(is_done(again)) << again.err << farm.logs();
  EXPECT_EQ(hashes("slurm"), hashes("whole"));
}

INSTANTIATE_TEST_SUITE_P(Shots, ShippedSweepLong,
                         testing::Values(ShippedSweep{"sweep_truck",
                                                      {"mpm.cell_size=0.05", "shot.frames=\"1-3\"",
                                                       "render.size=[64, 36]", "render.samples=1"}},
                                         ShippedSweep{"sweep_bunny",
                                                      {"shot.frames=\"1-2\"", "fem.newton_tolerance=1e-3",
                                                       "render.size=[64, 36]", "render.samples=1"}}),
                         [](const testing::TestParamInfo<ShippedSweep>& sweep) { return sweep.param.name; });

TEST_F(SlurmLong, AJobThatIsStoppedGoesBackIntoTheQueueAndOn) {
  SlurmFarm farm(m_folder.path() / "farm");
  ASSERT_EQ(farm.problem(), "") << farm.logs();
  const pid_t sweep = begin(arguments("s", "slurm"));
  wait_for_frames("s");
  shell("scancel --signal=TERM --batch --state=RUNNING --user=root"); // as preemption does
  int status = 0;
  int held = 0;
  for (int i = 0; i < 600 && waitpid(sweep, &status, WNOHANG) == 0; ++i) {
    if (held > 0 || shell("squeue --noheader --states=PENDING --format=%r | grep -q BeginTime"))
      ++held;
    // Let go before the node has cleared away its first run, a job is refused there as one that was killed.
    if (held > 15)
      shell(
          "for job in $(squeue --noheader --states=PENDING --format=%A); do scontrol update JobId=$job StartTime=now; "
          "done");
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
  EXPECT_GT(held, 0) << farm.logs();
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status << farm.logs();
  for (const std::vector<std::string>& frames : hashes("s"))
    EXPECT_EQ(frames.size(), 9u);
}

TEST_F(SlurmLong, CompletedWithoutHavingRunIsNoSuccess) {
  SlurmFarm farm(m_folder.path() / "farm");
  ASSERT_EQ(farm.problem(), "") << farm.logs();
  // A broken set-up of a node: the program is there, ends well, and does nothing.
  const fs::path fake = m_folder.path() / "bin";
  fs::create_directories(fake);
  write_text(fake / "sbatch", "#!/bin/sh\nsed 's#^\\(.*\\) job .*&$#true \\&#' | exec /usr/bin/sbatch \"$@\"\n");
  fs::permissions(fake / "sbatch", fs::perms::owner_all);
  const std::string path = std::getenv("PATH");
  setenv("PATH", (fake.string() + ":" + path).c_str(), 1);
  const Outcome outcome = run_wry(arguments("s", "slurm"), m_folder.path());
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
  EXPECT_THAT(outcome.err, testing::HasSubstr("4 of 4 wedges are not done"));
  EXPECT_THAT(outcome.err, testing::HasSubstr("simulate was not run"));
}

} // namespace
} // namespace wry::cli_test
