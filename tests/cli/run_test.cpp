#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

namespace fs = std::filesystem;

class Run : public testing::Test {
protected:
  Run() { write_text(shot(), small_shot()); }
  fs::path shot() const { return m_folder.path() / "bar.toml"; }
  fs::path out(const std::string& name) const { return m_folder.path() / name; }
  Outcome simulate(const std::string& name, std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {"simulate", "bar.toml", "--out", out(name).string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_wry(arguments, m_folder.path());
  }
  std::vector<std::string> simulate_arguments(const std::string& name) const {
    return {"simulate", "bar.toml", "--out", out(name).string()};
  }
  const TemporaryFolder m_folder;
};

TEST_F(Run, ASecondRunOfTheSameShotSimulatesNothing) {
  const Outcome first = simulate("a");
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const std::vector<std::string> hashes = frame_hashes(out("a"));
  ASSERT_EQ(hashes.size(), 9u);
  const std::string stats = read_text(out("a") / "stats.csv");
  const Outcome second = simulate("a");
  ASSERT_EQ(second.exit_code, 0) << second.err;
  EXPECT_NE(second.out.find("were there already"), std::string::npos) << second.out;
  EXPECT_EQ(frame_hashes(out("a")), hashes);
  EXPECT_EQ(read_text(out("a") / "stats.csv"), stats);
}

TEST_F(Run, FramesAreTheSameBitsOnAnyNumberOfThreads) {
  ASSERT_EQ(simulate("one", {"--threads", "1"}).exit_code, 0);
  const std::vector<std::string> one = frame_hashes(out("one"));
  ASSERT_EQ(one.size(), 9u);
  for (const char* threads : {"2", "3", "8"}) {
    ASSERT_EQ(simulate(threads, {"--threads", threads}).exit_code, 0);
    EXPECT_EQ(frame_hashes(out(threads)), one) << threads << " threads";
  }
}

TEST_F(Run, LaterFramesGoOnFromTheEarlierOnes) {
  ASSERT_EQ(simulate("whole").exit_code, 0);
  ASSERT_EQ(simulate("parts", {"--frames", "1-4"}).exit_code, 0);
  ASSERT_EQ(frame_hashes(out("parts")).size(), 4u);
  const Outcome rest = simulate("parts");
  ASSERT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_NE(rest.out.find("resumed from frame 4"), std::string::npos) << rest.out;
  EXPECT_EQ(frame_hashes(out("parts")), frame_hashes(out("whole")));
  EXPECT_EQ(read_text(out("parts") / "measure.csv"), read_text(out("whole") / "measure.csv"));
}

TEST_F(Run, KilledAtAnyInstantItResumesToTheSameBits) {
  ASSERT_EQ(simulate("whole").exit_code, 0);
  const std::vector<std::string> whole = frame_hashes(out("whole"));
  const char* asked = std::getenv("WRY_KILLS");
  const int kills = asked != nullptr ? std::atoi(asked) : 8;
  std::mt19937 random(7);
  int landed = 0;
  for (int done = 0; done < kills; ++done) {
    const fs::path folder = out("killed");
    fs::remove_all(folder);
    int rounds = 0;
    Outcome outcome;
    do {
      outcome = run_wry_and_signal(simulate_arguments("killed"), m_folder.path(), SIGKILL,
                                   std::uniform_int_distribution<int>(5, 400)(random));
      landed += outcome.exit_code == 128 + SIGKILL ? 1 : 0;
    } while (outcome.exit_code == 128 + SIGKILL && ++rounds < 4);
    ASSERT_EQ(simulate("killed").exit_code, 0);
    ASSERT_EQ(frame_hashes(folder), whole) << "after kill " << done;
    ASSERT_EQ(run_wry({"check", folder.string()}, m_folder.path()).exit_code, 0);
  }
  EXPECT_GT(landed, 0) << "no kill came before the end of the run";
  RecordProperty("kills_that_landed", landed);
}

TEST_F(Run, AskedToStopItWritesACheckpointAndGoesOnToTheSameBits) {
  ASSERT_EQ(simulate("whole").exit_code, 0);
  Outcome stopped;
  // Before main() the signal ends the program as it ends any; on a busy machine that is a while.
  for (int delay_ms = 120; delay_ms < 5000; delay_ms *= 2) {
    stopped = run_wry_and_signal(simulate_arguments("stopped"), m_folder.path(), SIGTERM, delay_ms);
    if (stopped.exit_code != 128 + SIGTERM)
      break;
  }
  if (stopped.exit_code != 0) {
    EXPECT_EQ(stopped.exit_code, 75) << stopped.err;
  }
  ASSERT_EQ(simulate("stopped").exit_code, 0);
  EXPECT_EQ(frame_hashes(out("stopped")), frame_hashes(out("whole")));
}

TEST_F(Run, AChangedValueNamesTheKeyThatMadeTheFramesStale) {
  ASSERT_EQ(simulate("a", {"--frames", "1-3"}).exit_code, 0);
  const std::vector<std::string> before = frame_hashes(out("a"));
  const Outcome changed = simulate("a", {"--frames", "1-3", "--set", "material.soft.youngs_modulus=5e4"});
  ASSERT_EQ(changed.exit_code, 0) << changed.err;
  EXPECT_NE(changed.err.find("material.soft.youngs_modulus"), std::string::npos) << changed.err;
  EXPECT_NE(frame_hashes(out("a")), before);
}

TEST_F(Run, AMeshThatDidNotChangeIsNotNamedThoughTheFolderIsElsewhere) {
  write_text(m_folder.path() / "tile.ply",
             "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
             "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
             "-1 0 -1\n1 0 -1\n1 0 1\n-1 0 1\n3 0 2 1\n3 0 3 2\n");
  write_text(shot(), small_shot() + "[[collider]]\nname = \"tile\"\nmesh = \"tile.ply\"\ntranslate = [0, 0.01, 0]\n");
  const TemporaryFolder elsewhere;
  const auto simulate_there = [&](const std::string& set) {
    return run_wry(
        {"simulate", "bar.toml", "--out", (elsewhere.path() / "o").string(), "--frames", "1-2", "--set", set},
        m_folder.path());
  };
  ASSERT_EQ(simulate_there("material.soft.poisson_ratio=0.3").exit_code, 0);
  const Outcome again = simulate_there("material.soft.poisson_ratio=0.2");
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.err.find("material.soft.poisson_ratio: 0.3 -> 0.2"), std::string::npos) << again.err;
  EXPECT_EQ(again.err.find("tile.ply"), std::string::npos) << again.err;
}

TEST_F(Run, AChangedPictureKeyKeepsTheFrames) {
  ASSERT_EQ(simulate("a", {"--frames", "1-3"}).exit_code, 0);
  const Outcome changed = simulate("a", {"--frames", "1-3", "--set", "render.exposure=1"});
  EXPECT_NE(changed.out.find("were there already"), std::string::npos) << changed.out << changed.err;
}

TEST_F(Run, ADamagedFrameIsNoticedAndMadeAgain) {
  ASSERT_EQ(simulate("a").exit_code, 0);
  const std::vector<std::string> whole = frame_hashes(out("a"));
  const fs::path frame = out("a") / "frames" / "0005.h5";
  std::string bytes = read_text(frame);
  bytes[bytes.size() / 2] ^= 0x10;
  write_text(frame, bytes);
  const Outcome check = run_wry({"check", out("a").string()}, m_folder.path());
  EXPECT_EQ(check.exit_code, 1);
  EXPECT_NE(check.out.find("0005.h5"), std::string::npos) << check.out;
  ASSERT_EQ(simulate("a").exit_code, 0);
  EXPECT_EQ(frame_hashes(out("a")), whole);
  EXPECT_EQ(run_wry({"check", out("a").string()}, m_folder.path()).exit_code, 0);
}

TEST_F(Run, KeepsAsManyCheckpointsAsTheShotAsksFor) {
  const auto kept = [&](const std::string& name) {
    return std::count_if(fs::directory_iterator(out(name) / "checkpoints"), fs::directory_iterator(),
                         [](const fs::directory_entry& file) { return file.path().extension() == ".h5"; });
  };
  ASSERT_EQ(simulate("one", {"--set", "fem.keep=1", "--set", "fem.checkpoint_every=0"}).exit_code, 0);
  EXPECT_EQ(kept("one"), 1);
  ASSERT_EQ(simulate("more", {"--set", "fem.keep=3", "--set", "fem.checkpoint_every=4"}).exit_code, 0);
  EXPECT_EQ(kept("more"), 4) << "7, 8 and 9, and 4";
}

TEST_F(Run, OnlyOneOfTwoRunsGetsTheFolder) {
  const std::vector<std::string> arguments = simulate_arguments("a");
  ASSERT_EQ(simulate("a", {"--frames", "1-2"}).exit_code, 0);
  const TemporaryFolder logs;
  // The first holds the lock while it is stopped in its tracks.
  const pid_t child = fork();
  if (child == 0) {
    if (chdir(m_folder.path().c_str()) != 0)
      _exit(126);
    execl(WRY_PROGRAM, WRY_PROGRAM, "simulate", "bar.toml", "--out", out("a").c_str(), "--quiet", nullptr);
    _exit(127);
  }
  for (int i = 0; i < 500 && frame_hashes(out("a")).size() < 3; ++i)
    usleep(2000);
  kill(child, SIGSTOP);
  const Outcome second = run_wry(arguments, m_folder.path());
  kill(child, SIGCONT);
  int status = 0;
  waitpid(child, &status, 0);
  if (frame_hashes(out("a")).size() == 9 && second.exit_code == 0)
    return; // the first had finished before it could be stopped
  EXPECT_EQ(second.exit_code, 73) << second.err;
  EXPECT_NE(second.err.find(std::to_string(child)), std::string::npos) << second.err;
}

} // namespace
} // namespace wry::cli_test
