#include <csignal>
#include <filesystem>
#include <random>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "pipeline/report/csv_table.h"
#include "render/png.h"
#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Sweep : public testing::Test {
protected:
  Outcome sweep(const std::string& section, std::vector<std::string> more = {}) const {
    write_text(m_folder.path() / "bar.toml", small_shot() + section);
    std::vector<std::string> arguments = {"sweep", "bar.toml", "--out", "s", "--frames", "1-3", "--isa", "sse4"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_wry(arguments, m_folder.path());
  }
  fs::path out() const { return m_folder.path() / "s"; }
  pipeline::CsvTable table() const { return pipeline::read_csv_table(out() / "sweep.csv"); }
  std::vector<std::string> column(const std::string& name) const {
    const pipeline::CsvTable read = table();
    std::vector<std::string> values;
    for (std::size_t c = 0; c < read.columns.size(); ++c) {
      for (const auto& row : read.rows) {
        if (read.columns[c] == name)
          values.push_back(row.at(c));
      }
    }
    return values;
  }
  const TemporaryFolder m_folder;
};

constexpr const char* TWO = "[sweep]\n\"material.soft.youngs_modulus\" = [2e4, 8e4]\n";
constexpr const char* THREE = "[sweep]\n\"material.soft.youngs_modulus\" = [1e4, 2e4, 8e4]\n";

TEST_F(Sweep, EveryWedgeIsWholeAndTheTableSheetAndPageTellOfAll) {
  const Outcome outcome = sweep(TWO);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(column("outcome"), (std::vector<std::string>{"done", "done"}));
  const std::vector<std::string> heights = column("height"), ids = column("wedge");
  ASSERT_EQ(heights.size(), 2u);
  EXPECT_NE(heights[0], heights[1]) << "a stiffer bar sags less";
  for (const std::string& id : ids) {
    const fs::path wedge = out() / "wedges" / id;
    EXPECT_EQ(frame_hashes(wedge).size(), 3u);
    EXPECT_TRUE(fs::exists(wedge / "report.html"));
    EXPECT_EQ(run_wry({"check", wedge.string()}, m_folder.path()).exit_code, 0);
  }
  EXPECT_TRUE(render::png_is_whole(out() / "sheet.beauty.png").ok());
  EXPECT_THAT(read_text(out() / "index.html"), HasSubstr(ids[1]));
  std::size_t meshes = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(out() / "shared"))
    meshes += entry.path().extension() == ".mesh" ? 1 : 0;
  EXPECT_EQ(meshes, 1u) << "both wedges have the same mesh: it is made once";
}

/// Two wedges that stand alike at the start only.
const std::string ALIKE = R"([[sweep.case]]
name = "soft"
set = { "material.soft.youngs_modulus" = 1e4 }
[[sweep.case]]
name = "stiff"
set = { "material.soft.youngs_modulus" = 8e5 }
[expect.alike]
measure = "height"
ratio_to = "soft"
min = 0.9999999
max = 1.0000001
)";

TEST_F(Sweep, RatiosBetweenWedgesAreOfTheirFrameAndWithoutACaseOfEveryOtherWedge) {
  EXPECT_EQ(sweep(ALIKE + "frame = 1\n").exit_code, 0) << "at the start both stand as they were made";
  const Outcome later = sweep(ALIKE + "frame = 3\n");
  EXPECT_EQ(later.exit_code, 1);
  EXPECT_THAT(later.err, HasSubstr("height of stiff over soft is"));
  EXPECT_THAT(later.err, HasSubstr("at frame 3"));
  const Outcome cut = sweep(ALIKE);
  EXPECT_EQ(cut.exit_code, 0) << cut.err;
  EXPECT_THAT(cut.out, HasSubstr("not judged: alike (frame 9 was not asked for)"));
  const Outcome last = sweep(ALIKE, {"--set", "shot.frames=\"1-3\""});
  EXPECT_EQ(last.exit_code, 1) << "the shot's last frame, where none is named";
  EXPECT_THAT(last.err, HasSubstr("at frame 3"));
}

TEST_F(Sweep, RatiosAreJudgedBesideWhatAWedgeFailsByItself) {
  const Outcome outcome = sweep(ALIKE + R"([expect.impossible]
measure = "height"
case = "stiff"
max = 0
)",
                                {"--set", "shot.frames=\"1-3\""});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("expect.impossible"));
  EXPECT_THAT(outcome.err, HasSubstr("height of stiff over soft is"));
}

TEST_F(Sweep, AddedValuesKeepNumbersAndRepeatNothing) {
  ASSERT_EQ(sweep(TWO).exit_code, 0);
  const std::vector<std::string> before = column("wedge");
  const fs::path record = out() / "wedges" / before[0] / "jobs" / "simulate.json";
  const std::string ran = read_text(record);
  ASSERT_EQ(sweep(THREE).exit_code, 0);
  const std::vector<std::string> after = column("wedge");
  ASSERT_EQ(after.size(), 3u);
  EXPECT_EQ(after[0].substr(0, 4), "002-") << "the new value stands first in the file and gets the next free number";
  EXPECT_EQ(after[1], before[0]);
  EXPECT_EQ(after[2], before[1]);
  EXPECT_EQ(read_text(record), ran) << "what was done is not run again: its record holds the same times";
}

TEST_F(Sweep, APoisonedWedgeIsNamedAndTheOthersFinish) {
  const Outcome outcome = sweep("[sweep]\n\"material.soft.poisson_ratio\" = [0.3, 0.7, 0.2]\n");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(column("outcome"), (std::vector<std::string>{"done", "failed", "done"}));
  EXPECT_THAT(column("reason")[1], HasSubstr("poisson_ratio"));
  EXPECT_THAT(outcome.err, HasSubstr("1 of 3 wedges"));
  EXPECT_THAT(read_text(out() / "index.html"), HasSubstr("poisson_ratio"));
}

TEST_F(Sweep, RecordsThatTheFramesDoNotBearOutDoNotCount) {
  ASSERT_EQ(sweep(TWO).exit_code, 0);
  const std::string id = column("wedge")[1];
  const std::vector<std::string> whole = frame_hashes(out() / "wedges" / id);
  fs::remove(out() / "wedges" / id / "frames" / "0002.h5");
  const Outcome listed = sweep(TWO, {"--list"});
  EXPECT_THAT(listed.out, HasSubstr("its jobs say that it is done, but"));
  EXPECT_EQ(sweep(TWO, {"--only-failed"}).exit_code, 0);
  EXPECT_EQ(frame_hashes(out() / "wedges" / id), whole);
}

TEST_F(Sweep, TheJobGraphIsAllThatAnotherFarmNeeds) {
  const Outcome listed = sweep(TWO, {"--list", "--json", "--chunk", "2"});
  ASSERT_EQ(listed.exit_code, 0) << listed.err;
  const nlohmann::json graph = nlohmann::json::parse(listed.out);
  std::set<std::string> done;
  int rendering = 0;
  for (const nlohmann::json& job : graph.at("jobs")) {
    for (const std::string id : job.at("after"))
      EXPECT_TRUE(done.contains(id)) << job.at("id") << " stands before " << id;
    std::vector<std::string> words = job.at("command");
    EXPECT_EQ(fs::path(words.front()), fs::canonical(WRY_PROGRAM));
    words.erase(words.begin());
    if (job.at("stage") != "sheet") {
      EXPECT_EQ(run_wry(words, m_folder.path()).exit_code, 0) << job.at("id");
    }
    done.insert(job.at("id"));
    rendering += words.front() == "render" ? 1 : 0;
  }
  EXPECT_EQ(rendering, 4) << "frames 1-2 and 3 of two wedges";
  for (const fs::directory_entry& wedge : fs::directory_iterator(out() / "wedges"))
    EXPECT_EQ(frame_hashes(wedge.path()).size(), 3u);
}

TEST_F(Sweep, KilledAtAnyInstantItGoesOnToTheSameBits) {
  ASSERT_EQ(sweep(TWO).exit_code, 0);
  fs::rename(out(), m_folder.path() / "whole");
  std::vector<std::vector<std::string>> whole;
  std::vector<std::string> ids;
  for (const auto& row : pipeline::read_csv_table(m_folder.path() / "whole" / "sweep.csv").rows) {
    ids.push_back(row[0]);
    whole.push_back(frame_hashes(m_folder.path() / "whole" / "wedges" / row[0]));
  }
  std::mt19937 random(11);
  const std::vector<std::string> arguments = {"sweep", "bar.toml", "--out", "s",      "--frames",
                                              "1-3",   "--isa",    "sse4",  "--jobs", "2"};
  int landed = 0;
  for (int kill = 0; kill < 3; ++kill)
    landed += run_wry_and_signal(arguments, m_folder.path(), kill % 2 == 0 ? SIGKILL : SIGTERM,
                                 std::uniform_int_distribution<int>(40, 400)(random))
                          .exit_code != 0
                  ? 1
                  : 0;
  EXPECT_GT(landed, 0);
  const Outcome last = run_wry(arguments, m_folder.path());
  ASSERT_EQ(last.exit_code, 0) << last.err;
  for (std::size_t i = 0; i < ids.size(); ++i)
    EXPECT_EQ(frame_hashes(out() / "wedges" / ids[i]), whole[i]) << ids[i];
}

TEST_F(Sweep, AFarmThatIsNotThereIsSaidSo) {
  if (std::system("command -v sbatch >/dev/null && sinfo >/dev/null 2>&1") == 0)
    GTEST_SKIP() << "this machine is on a farm";
  const Outcome outcome = sweep(TWO, {"--engine", "slurm"});
  EXPECT_EQ(outcome.exit_code, 69) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("--list --json"));
  EXPECT_EQ(sweep(TWO, {"--engine", "moon"}).exit_code, 2);
}

} // namespace
} // namespace wry::cli_test
