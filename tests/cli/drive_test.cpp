#include <cmath>

#include <gtest/gtest.h>

#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

/// The value of a column in the last row of measure.csv.
double last_of(const std::string& csv, const std::string& column) {
  std::vector<std::string> lines;
  std::size_t begin = 0;
  for (std::size_t end = csv.find('\n'); end != std::string::npos; begin = end + 1, end = csv.find('\n', begin))
    lines.push_back(csv.substr(begin, end - begin));
  const auto fields = [](const std::string& line) {
    std::vector<std::string> out(1);
    for (const char c : line) {
      if (c == ',')
        out.emplace_back();
      else
        out.back().push_back(c);
    }
    return out;
  };
  const std::vector<std::string> names = fields(lines.front());
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == column)
      return std::stod(fields(lines.back())[i]);
  }
  ADD_FAILURE() << "no column " << column;
  return 0.0;
}

TEST(DriveProgram, AShotTwistsABarAndMeasuresIt) {
  const TemporaryFolder folder;
  write_text(folder.path() / "twist.toml", R"(
[shot]
name = "twist"
frames = "1-11"
fps = 50
gravity = [0, 0, 0]

[[body]]
name = "bar"
rod = { length = 0.4, width = 0.1 }
cells = [8, 2, 2]
split = "kuhn"
material = "soft"

[material.soft]
model = "micropolar"
youngs_modulus = 1e4
poisson_ratio = 0.3

[[fixed]]
name = "left"
where = { expression = "u < 1e-6" }

[[drive]]
name = "right"
where = { expression = "u > 1 - 1e-6" }
keys = [{ time = 0 }, { time = 0.2, axis = "x", degrees = 90 }]

[[measure]]
name = "torque"
kind = "reaction_torque"
axis = "x"
where = { expression = "u > 1 - 1e-6" }

[[measure]]
name = "twist"
kind = "element_twist_max"

[[measure]]
name = "error"
kind = "rotation_interpolation_error"

[[measure]]
name = "tip"
kind = "tip_position"
axis = "x"
)");
  const Outcome outcome = run_wry({"simulate", "twist.toml", "--out", "out"}, folder.path());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::string csv = read_text(folder.path() / "out/measure.csv");
  EXPECT_GT(last_of(csv, "torque"), 0.0);
  EXPECT_NEAR(last_of(csv, "tip"), 0.2, 1e-9);
  EXPECT_GT(last_of(csv, "twist"), 90.0 / 8.0);
  EXPECT_GT(last_of(csv, "error"), 0.0);
  EXPECT_LT(last_of(csv, "error"), 1.0);
}

} // namespace
} // namespace wry::cli_test
