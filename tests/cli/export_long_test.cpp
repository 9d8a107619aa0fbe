#include <algorithm>
#include <cmath>
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

TEST(ExportReadByParaView, TheSeriesOpensWithOurMeshAndFields) {
  if (!shell("command -v pvbatch && /usr/bin/python3 -c 'import paraview'"))
    GTEST_SKIP() << "needs paraview and python3-paraview";
  const TemporaryFolder folder;
  const std::string root = folder.path().string();
  write_text(folder.path() / "bar.toml", small_shot());
  ASSERT_EQ(run_wry({"simulate", "bar.toml", "--out", "o"}, folder.path()).exit_code, 0);
  ASSERT_EQ(run_wry({"export", "bar.toml", "--out", "o", "--to", "xdmf"}, folder.path()).exit_code, 0);
  const std::string command = std::string("QT_QPA_PLATFORM=offscreen pvbatch ") + WRY_TEST_DATA +
                              "/tools/read_xdmf.py " + root + "/o/exports/xdmf/bar.xdmf > " + root + "/read.json";
  ASSERT_EQ(std::system(command.c_str()), 0) << read_text(folder.path() / "read.json");
  const nlohmann::json steps = nlohmann::json::parse(read_text(folder.path() / "read.json")).at("steps");
  const Result<pipeline::FrameCache> cache = pipeline::FrameCache::open_to_read(folder.path() / "o" / "frames");
  const SceneBody body = cache->read_static()->bodies.at(0);
  ASSERT_EQ(steps.size(), 9u);
  for (int number = 1; number <= 9; ++number) {
    const nlohmann::json& step = steps[static_cast<std::size_t>(number) - 1];
    const Result<Frame> frame = cache->read_frame(number);
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_DOUBLE_EQ(step.at("time").get<double>(), frame->time);
    EXPECT_EQ(step.at("points"), body.rest_positions.rows());
    EXPECT_EQ(step.at("cells"), body.tets.rows());
    const Channel* position = find_channel(frame->bodies[0], "position");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double low = INFINITY, high = -INFINITY;
      for (std::size_t i = axis; i < position->values.size(); i += 3) {
        low = std::min(low, position->values[i]);
        high = std::max(high, position->values[i]);
      }
      EXPECT_DOUBLE_EQ(step.at("bounds")[2 * axis].get<double>(), low);
      EXPECT_DOUBLE_EQ(step.at("bounds")[2 * axis + 1].get<double>(), high);
    }
    for (const char* name : {"velocity", "microrotation", "angular_velocity"})
      EXPECT_TRUE(step.at("point_arrays").contains(name)) << name;
    EXPECT_TRUE(step.at("cell_arrays").contains("strain_energy_density"));
  }
}

} // namespace
} // namespace wry::cli_test
