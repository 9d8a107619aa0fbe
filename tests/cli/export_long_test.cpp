#include <cstdlib>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "pipeline/cache/frame_cache.h"
#include "tests/cli/program_support.h"
#include "tests/cli/slurm_support.h"

namespace wry::cli_test {
namespace {

TEST(ExportReadByTinyUsdz, TheStageOpensWithOurMesh) {
  const TemporaryFolder folder;
  const std::string root = folder.path().string();
  if (!shell("cd " + root + " && npm install --no-audit --no-fund tinyusdz@0.9.0-rc10"))
    GTEST_SKIP() << "needs node, npm and its registry";
  write_text(folder.path() / "bar.toml", small_shot());
  ASSERT_EQ(run_wry({"simulate", "bar.toml", "--out", "o", "--frames", "1-2"}, folder.path()).exit_code, 0);
  ASSERT_EQ(run_wry({"export", "bar.toml", "--out", "o", "--frames", "1-2", "--to", "usda"}, folder.path()).exit_code,
            0);
  const std::string command = std::string("node ") + WRY_TEST_DATA + "/tools/read_usd.mjs " + root +
                              "/o/exports/usda/bar.usda " + root + " > " + root + "/read.json";
  ASSERT_EQ(std::system(command.c_str()), 0) << read_text(folder.path() / "read.json");
  const nlohmann::json read = nlohmann::json::parse(read_text(folder.path() / "read.json"));
  ASSERT_TRUE(read.at("ok").get<bool>());
  ASSERT_EQ(read.at("meshes").size(), 1u);
  const Result<pipeline::FrameCache> cache = pipeline::FrameCache::open_to_read(folder.path() / "o" / "frames");
  const SceneBody body = cache->read_static()->bodies.at(0);
  EXPECT_EQ(read["meshes"][0]["name"], "bar");
  EXPECT_EQ(read["meshes"][0]["faces"], body.triangles.rows());
  EXPECT_GT(read["meshes"][0]["points"].get<int>(), 0);
}

} // namespace
} // namespace wry::cli_test
