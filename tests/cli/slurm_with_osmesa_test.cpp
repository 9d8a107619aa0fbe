#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/report/csv_table.h"
#include "tests/cli/program_support.h"
#include "tests/cli/slurm_support.h"

namespace wry::cli_test {
namespace {

// Takes several seconds, most of them waiting for Slurm's own rhythm of one second; the harder ones are in
// slurm_with_osmesa_long_test.cpp.
TEST(Slurm, ASweepRunsAsArraysWhereEachRenderFollowsItsOwnSimulation) {
  if (!SlurmFarm::is_installed())
    GTEST_SKIP() << "needs root, slurm-wlm and munge";
  const TemporaryFolder folder;
  const SlurmFarm farm(folder.path() / "farm");
  ASSERT_EQ(farm.problem(), "") << farm.logs();
  write_text(folder.path() / "bar.toml", small_shot() + "[sweep]\n\"material.soft.youngs_modulus\" = [2e4, 8e4]\n"
                                                        "\"material.soft.poisson_ratio\" = [0.3, 0.7]\n");
  const Outcome outcome = run_wry(
      {"sweep", "bar.toml", "--out", "s", "--frames", "1-2", "--engine", "slurm", "--jobs", "4", "--isa", "sse4"},
      folder.path());
  EXPECT_EQ(outcome.exit_code, 1) << outcome.err << farm.logs();
  const pipeline::CsvTable table = pipeline::read_csv_table(folder.path() / "s" / "sweep.csv");
  ASSERT_EQ(table.rows.size(), 4u) << outcome.err;
  for (const auto& row : table.rows) {
    const bool poisoned = row[3] == "0.7";
    EXPECT_EQ(row[4], poisoned ? "failed" : "done") << row[0] << ": " << row[6];
    EXPECT_EQ(frame_hashes(folder.path() / "s" / "wedges" / row[0]).size(), poisoned ? 0u : 2u);
  }
  EXPECT_THAT(outcome.err, testing::HasSubstr("poisson_ratio"));
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "s" / "sheet.beauty.png")) << "the sheet comes last";
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "s" / "farm" / "finish-0.log")) << "logs are gathered";
}

} // namespace
} // namespace wry::cli_test
