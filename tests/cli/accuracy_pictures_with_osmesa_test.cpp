#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/report/csv_table.h"
#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

using ::testing::HasSubstr;

TEST(AccuracyPictures, AreDrawnFromTheFramesOfOneRunAndComeNearerWithMoreSamples) {
  const TemporaryFolder folder;
  write_text(folder.path() / "bar.toml", small_shot() + R"(
[accuracy]
frames = "2"
repeats = 2
"render.samples" = [1, 4]
reference = { "render.samples" = 16 }
)");
  const std::vector<std::string> arguments = {"accuracy", "bar.toml", "--out", "o", "--set", "render.size=[160,90]"};
  const Outcome outcome = run_wry(arguments, folder.path());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err << outcome.out;
  const std::filesystem::path results = folder.path() / "o" / "accuracy";
  const pipeline::CsvTable table = pipeline::read_csv_table(results / "pictures.csv");
  const std::vector<double> errors = table.numbers("picture_error");
  ASSERT_EQ(errors.size(), 2u) << outcome.out;
  EXPECT_GT(errors[0], errors[1]);
  EXPECT_GT(errors[1], 0.0);
  EXPECT_THAT(outcome.out, HasSubstr("picture over render.samples: observed order"));
  std::size_t simulated = 0, drawn = 0;
  for (const auto& entry : std::filesystem::directory_iterator(results / "rungs"))
    simulated += entry.is_directory() ? 1 : 0;
  for (const auto& entry : std::filesystem::directory_iterator(results / "pictures")) {
    drawn += entry.is_directory() ? 1 : 0;
    EXPECT_TRUE(std::filesystem::is_symlink(entry.path() / "frames")) << "frames are not simulated again";
    EXPECT_FALSE(std::filesystem::exists(entry.path() / "timing-1")) << "repeats are run for their time alone";
    EXPECT_TRUE(std::filesystem::exists(entry.path() / "jobs" / "timing-1.json"));
  }
  EXPECT_EQ(simulated, 1u);
  EXPECT_EQ(drawn, 3u) << "two rungs, one of which is the shot as it is, and their reference";
  const std::string before = read_text(results / "pictures.csv");
  ASSERT_EQ(run_wry(arguments, folder.path()).exit_code, 0);
  EXPECT_EQ(read_text(results / "pictures.csv"), before) << "nothing is drawn twice";
}

} // namespace
} // namespace wry::cli_test
