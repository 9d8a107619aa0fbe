#include <cstdio>
#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cli/program_support.h"
#include "tests/cli/slurm_support.h"

namespace wry::cli_test {
namespace {

TEST(ExportReadByOpenVdb, TheirToolPrintsTheLevelSet) {
  if (!shell("command -v vdb_print"))
    GTEST_SKIP() << "needs libopenvdb-tools";
  const TemporaryFolder folder;
  write_text(folder.path() / "bar.toml", small_shot());
  ASSERT_EQ(run_wry({"simulate", "bar.toml", "--out", "o", "--frames", "1-2"}, folder.path()).exit_code, 0);
  const Outcome outcome =
      run_wry({"export", "bar.toml", "--out", "o", "--frames", "1-2", "--to", "vdb"}, folder.path());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::string listing = (folder.path() / "listing").string();
  ASSERT_EQ(std::system(
                ("vdb_print -l " + (folder.path() / "o/exports/vdb/bar.0002.vdb").string() + " > " + listing).c_str()),
            0);
  const std::string text = read_text(listing);
  EXPECT_THAT(text, testing::HasSubstr("bar_surface"));
  EXPECT_THAT(text, testing::HasSubstr("level set"));
}

} // namespace
} // namespace wry::cli_test
