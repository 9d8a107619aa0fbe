#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/children_support.h"
#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

namespace fs = std::filesystem;

/// A shipped shot, simulated as far as is needed to judge what `wry plan` says of it.
struct PredictedShot {
  std::string name;
  std::vector<std::string> sets;
};

void PrintTo(const PredictedShot& shot, std::ostream* stream) {
  *stream << shot.name;
}

std::vector<PredictedShot> predicted_shots() {
  std::vector<PredictedShot> shots;
  for (const fs::directory_entry& file : fs::directory_iterator(std::string(WRY_SOURCE_DIR) + "/shots"))
    if (file.path().extension() == ".toml")
      shots.push_back({file.path().stem().string(), {}});
  std::sort(shots.begin(), shots.end(), [](const PredictedShot& a, const PredictedShot& b) { return a.name < b.name; });
  for (PredictedShot& shot : shots)
    if (shot.name == "lotus_bowl") // its flowers have met each other after a second
      shot.sets = {"shot.frames=\"1-37\""};
  return shots;
}

class PredictionLong : public testing::TestWithParam<PredictedShot> {};

/// Time is the CPU time of one thread: the constants of the prediction are those of the machine in the README, and a
/// machine half or twice as fast as that fails here by right.
TEST_P(PredictionLong, OfTimeMemoryAndDiskIsWithinAFactorOfTwo) {
  const TemporaryFolder folder;
  const std::string shot = std::string(WRY_SOURCE_DIR) + "/shots/" + GetParam().name + ".toml";
  std::vector<std::string> sets;
  for (const std::string& set : GetParam().sets)
    sets.insert(sets.end(), {"--set", set});
  std::vector<std::string> words = {"plan", shot, "--json"};
  words.insert(words.end(), sets.begin(), sets.end());
  const Outcome plan = run_wry(words, folder.path());
  ASSERT_EQ(plan.exit_code, 0) << plan.err;
  const nlohmann::json cost = nlohmann::json::parse(plan.out).at("cost");

  words = {"simulate", shot, "--threads", "1", "--quiet", "--out", (folder.path() / "out").string()};
  words.insert(words.end(), sets.begin(), sets.end());
  const double before = cpu_seconds_of_children(), peak_before = peak_bytes_of_children();
  const Outcome run = run_wry(words, folder.path());
  const double seconds = cpu_seconds_of_children() - before;
  ASSERT_EQ(run.exit_code, 0) << run.err;

  const double peak = peak_bytes_of_children(), predicted_peak = cost.at("memory_bytes").get<double>();
  const double predicted = cost.at("seconds").get<double>();
  const double disk = bytes_in(folder.path() / "out");
  const double predicted_disk = cost.at("disk_bytes").get<double>();
  fmt::print("{:16} time {:6.1f} s, predicted {:6.1f}: {:4.2f}   disk {:6.1f} MB, predicted {:6.1f}: {:4.2f}   memory "
             "{:4.0f} MB, predicted {:4.0f}: {:4.2f}\n",
             GetParam().name, seconds, predicted, predicted / seconds, 1e-6 * disk, 1e-6 * predicted_disk,
             predicted_disk / disk, 1e-6 * peak, 1e-6 * predicted_peak, predicted_peak / peak);
  // What a second or a megabyte decides is not worth predicting.
  if (std::max(seconds, predicted) > 2.0) {
    EXPECT_GT(predicted / seconds, 0.5);
    EXPECT_LT(predicted / seconds, 2.0);
  }
  if (std::max(disk, predicted_disk) > 2e6) {
    EXPECT_GT(predicted_disk / disk, 0.5);
    EXPECT_LT(predicted_disk / disk, 2.0);
  }
  if (peak > peak_before) { // else an earlier one was larger, where one process runs several of these tests
    EXPECT_GT(predicted_peak / peak, 0.5);
    EXPECT_LT(predicted_peak / peak, 2.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Shots, PredictionLong, testing::ValuesIn(predicted_shots()),
                         [](const testing::TestParamInfo<PredictedShot>& shot) { return shot.param.name; });

} // namespace
} // namespace wry::cli_test
