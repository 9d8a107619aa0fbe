#include <cmath>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/report/csv_table.h"
#include "render/png.h"
#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::vector<std::string> column(const pipeline::CsvTable& table, const std::string& name) {
  std::vector<std::string> values;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    for (const auto& row : table.rows) {
      if (table.columns[c] == name)
        values.push_back(row.at(c));
    }
  }
  return values;
}

TEST(AccuracyVerb, ErrorsFallWithTheTimeStepAndTheOrderIsThatOfTheIntegrator) {
  const TemporaryFolder folder;
  // In free fall backward Euler is wrong by g t dt / 2 exactly: the height is too low by it.
  write_text(folder.path() / "bar.toml", R"([shot]
frames = "1-5"
fps = 25
[[body]]
name = "block"
box = { size = [0.1, 0.1, 0.1] }
resolution = 0.1
material = "soft"
[material.soft]
model = "neo-hookean"
density = 1000
youngs_modulus = 1e5
poisson_ratio = 0.3
[[measure]]
name = "low"
kind = "lowest"
[accuracy]
tolerance = 0.1
"fem.time_step" = [2e-2, 1e-2, 5e-3]
reference = { "fem.time_step" = 2e-4 }
)");
  const Outcome outcome = run_wry({"accuracy", "bar.toml", "--out", "o"}, folder.path());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err << outcome.out;
  const pipeline::CsvTable table = pipeline::read_csv_table(folder.path() / "o" / "accuracy" / "accuracy.csv");
  const std::vector<double> errors = table.numbers("low_error");
  ASSERT_EQ(errors.size(), 3u);
  EXPECT_NEAR(errors[0] / errors[1], 2.0, 0.15) << outcome.out;
  EXPECT_NEAR(errors[1] / errors[2], 2.0, 0.15) << outcome.out;
  EXPECT_THAT(outcome.out, HasSubstr("low over fem.time_step: observed order 1.0"));
  EXPECT_THAT(outcome.out, HasSubstr("for 10 % of low: fem.time_step"));
  EXPECT_TRUE(render::png_is_whole(folder.path() / "o" / "accuracy" / "plot-00.png").ok());
  const std::string record = read_text(folder.path() / "o/accuracy/rungs" / "000-e3b0c442" / "jobs" / "simulate.json");
  ASSERT_EQ(run_wry({"accuracy", "bar.toml", "--out", "o"}, folder.path()).exit_code, 0);
  EXPECT_EQ(read_text(folder.path() / "o/accuracy/rungs" / "000-e3b0c442" / "jobs" / "simulate.json"), record)
      << "no rung is computed twice";
  const std::string log = "o/accuracy/rungs/000-e3b0c442/jobs/simulate.log";
  ASSERT_EQ(run_wry({"accuracy", "bar.toml", "--out", "o", "--fresh"}, folder.path()).exit_code, 0);
  EXPECT_THAT(read_text(folder.path() / log), Not(HasSubstr("there already"))) << "--fresh times the work, not nothing";
}

TEST(StressVerb, TellsWhatHoldsFromWhatIsRefused) {
  const TemporaryFolder folder;
  write_text(folder.path() / "bar.toml", small_shot() + R"(
[stress]
frames = "1-2"
"material.soft.poisson_ratio" = [0.3, 0.49, 0.5]
"material.soft.youngs_modulus" = [1e3, 1e6]
)");
  const Outcome outcome = run_wry({"stress", "bar.toml", "--out", "o", "--set", "stress.pairs=false"}, folder.path());
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err << outcome.out;
  const fs::path results = folder.path() / "o" / "stress";
  const std::vector<std::string> outcomes = column(pipeline::read_csv_table(results / "stress.csv"), "outcome");
  ASSERT_EQ(outcomes.size(), 5u);
  EXPECT_THAT(outcomes[0], HasSubstr("holds"));
  EXPECT_EQ(outcomes[2], "refuses") << "an incompressible solid has no such modulus";
  EXPECT_THAT(read_text(results / "stress.csv"), HasSubstr("poisson_ratio"));
  EXPECT_TRUE(render::png_is_whole(results / "map.png").ok());
  EXPECT_THAT(outcome.out, HasSubstr("material.soft.poisson_ratio: holds at 0.3, 0.49"));
}

} // namespace
} // namespace wry::cli_test
