#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

/// The shipped shot on a coarse mesh with thumbnails: its own [expect] decides the exit code.
Outcome run_coarse_bunny(const std::vector<std::string>& more) {
  const TemporaryFolder folder;
  std::vector<std::string> arguments = {"run",
                                        std::string(WRY_SOURCE_DIR) + "/shots/bunny.toml",
                                        "--out",
                                        (folder.path() / "out").string(),
                                        "--quiet",
                                        "--set",
                                        "body.bunny.resolution=0.08",
                                        "--set",
                                        "render.size=[64, 36]",
                                        "--set",
                                        "render.samples=1"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_wry(arguments, folder.path());
}

TEST(Bunny, SoftNeoHookeanMatterCollapses) {
  const Outcome outcome = run_coarse_bunny({"--case", "soft-neo-hookean"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

TEST(Bunny, StiffNeoHookeanMatterStands) {
  const Outcome outcome = run_coarse_bunny({"--case", "stiff-neo-hookean"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

TEST(Bunny, AnExpectationThatDoesNotHoldIsNamedAndEndsWithOne) {
  const Outcome outcome = run_coarse_bunny({"--case", "soft-neo-hookean", "--set", "material.skin.youngs_modulus=2e6"});
  EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
  EXPECT_NE(outcome.err.find("soft-neo-hookean-collapses"), std::string::npos) << outcome.err;
}

} // namespace
} // namespace wry::cli_test
