#include <string>

#include <gtest/gtest.h>

#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

/// A cube of 0.2 m whose vertex colours go from red (1, 0, 0) on its left to blue (0, 0, 1) on its right.
std::string painted_cube() {
  std::string obj;
  for (int i = 0; i < 8; ++i) {
    const bool right = (i & 1) != 0;
    obj += "v " + std::string(right ? "0.2" : "0") + ((i & 2) != 0 ? " 0.2" : " 0") + ((i & 4) != 0 ? " 0.2" : " 0") +
           (right ? " 0 0 1\n" : " 1 0 0\n");
  }
  return obj + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
}

const std::string PAINTED = R"([shot]
name = "painted"
frames = "1"
[[body]]
name = "block"
mesh = "cube.obj"
material = "straw"
fibre = { expression = { x = "colour_x", z = "colour_z" } }
[material.straw]
model = "mpm"
youngs_modulus = { x = 1e5, y = 1e5, z = 5e4 }
poisson_ratio = 0.3
stiffness_scale = "1 + colour_x"
[mpm]
cell_size = 0.025
[[measure]]
name = "left"
kind = "mean_alignment"
axis = "x"
where = { box = { min = [0, 0, 0], max = [0.02, 1, 1] } }
[[measure]]
name = "right"
kind = "mean_alignment"
axis = "x"
where = { box = { min = [0.18, 0, 0], max = [1, 1, 1] } }
)";

TEST(MpmAttributes, FibresFollowTheColoursOfTheArtistsMesh) {
  const TemporaryFolder folder;
  write_text(folder.path() / "cube.obj", painted_cube());
  write_text(folder.path() / "painted.toml", PAINTED);
  const Outcome done = run_wry({"simulate", "painted.toml", "--out", (folder.path() / "out").string()}, folder.path());
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const std::string measured = read_text(folder.path() / "out" / "measure.csv");
  const std::string row = measured.substr(measured.find('\n') + 1);
  const std::size_t second = row.find(',', row.find(',') + 1) + 1;
  const double left = std::stod(row.substr(second)), right = std::stod(row.substr(row.find(',', second) + 1));
  EXPECT_GT(left, 0.97) << measured;
  EXPECT_LT(right, 0.03) << measured;
}

TEST(MpmAttributes, ANameThatTheMeshLacksIsRefusedWithTheNearest) {
  const TemporaryFolder folder;
  write_text(folder.path() / "cube.obj", painted_cube());
  std::string text = PAINTED;
  text.replace(text.find("1 + colour_x"), 12, "1 + colour_w");
  write_text(folder.path() / "painted.toml", text);
  const Outcome plan = run_wry({"plan", "painted.toml"}, folder.path());
  EXPECT_EQ(plan.exit_code, 65);
  EXPECT_NE(plan.err.find("painted.toml:13"), std::string::npos) << plan.err;
  EXPECT_NE(plan.err.find("colour_"), std::string::npos) << plan.err;
}

} // namespace
} // namespace wry::cli_test
