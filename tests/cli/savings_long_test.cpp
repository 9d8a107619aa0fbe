#include <algorithm>
#include <cctype>
#include <cmath>
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

/// A part that the shot leaves out, and lines that put it in.
struct LeftOutPart {
  std::string name;              ///< in `wry plan`
  std::string without;           ///< the shot
  std::string lines;             ///< that follow it, and
  std::vector<std::string> sets; ///< given to the program, put the part in
};

void PrintTo(const LeftOutPart& part, std::ostream* stream) {
  *stream << part.name;
}

std::string falling_block(const std::string& material) {
  return R"([shot]
name = "block"
frames = "1-13"
fps = 24
up = "y"

[[body]]
name = "block"
box = { size = [0.4, 0.4, 0.4] }
cells = [14, 14, 14]
translate = [0, 0.25, 0]
velocity = [0.2, -1, 0]
material = "soft"

[[collider]]
name = "floor"
plane = { height = 0 }
friction = 0

[material.soft]
density = 1000
youngs_modulus = 2e4
poisson_ratio = 0.3
)" + material;
}

std::string column(const std::string& rest) {
  return R"([shot]
name = "column"
frames = "1-13"
fps = 24
up = "z"

[[body]]
name = "column"
region = { box = { min = [-0.1, -0.1, 0], max = [0.1, 0.1, 0.3] } }
material = "sand"

[mpm]
cell_size = 0.0125

[[collider]]
name = "floor"
plane = { height = 0 }

[material.sand]
model = "mpm"
density = 1500
plasticity = "drucker-prager"
poisson_ratio = 0.3
)" + rest;
}

std::vector<LeftOutPart> parts() {
  const std::string classic = falling_block("model = \"neo-hookean\"\n");
  const std::string micropolar = falling_block("model = \"micropolar\"\n");
  const std::string sand = column("youngs_modulus = 1e5\n");
  const std::string straw = column("youngs_modulus = { x = 1e5, y = 1e5, z = 2e5 }\n");
  const std::string reaction = "[[measure]]\nname = \"push\"\nkind = \"reaction_force\"\naxis = \"y\"\n";
  const std::string error = "[[measure]]\nname = \"error\"\nkind = \"curvature_error\"\n";
  std::vector<std::string> reorient = {"material.sand.reorient.length_over_width=5"};
  for (const char* limit : {"isotropic", "parallel", "perpendicular"}) {
    reorient.push_back(fmt::format("material.sand.reorient.{}.youngs_modulus=2e5", limit));
    reorient.push_back(fmt::format("material.sand.reorient.{}.poisson_ratio=0.3", limit));
  }
  return {
      {"microrotations", classic, "", {"material.soft.model=micropolar"}},
      {"curvature energy", micropolar, "", {"material.soft.length_scale=0.04"}},
      {"friction", classic, "", {"collider.floor.friction=0.5"}},
      {"contact within bodies", classic, "", {"contact.within=true", "contact.between=false"}},
      {"stiffness damping", classic, "", {"material.soft.stiffness_damping=1e-3"}},
      {"reactions", classic, reaction, {}},
      {"rotations of quadrature points in frames", micropolar, error, {}},
      {"double precision", sand, "", {"mpm.precision=f64"}},
      {"material frames and maps of column",
       sand,
       "",
       {"material.sand.plastic_scale.x=1", "material.sand.plastic_scale.y=1", "material.sand.plastic_scale.z=1.1"}},
      {"second moments of grains of column", straw, "", reorient},
      {"grains",
       sand,
       "",
       {"body.column.sub_particles.per_particle=4", "body.column.sub_particles.size=[0.002, 0.002, 0.01]"}},
      {"semi-implicit steps", sand, "", {"mpm.semi_implicit.courant=4"}},
  };
}

/// What a shot takes, predicted or measured.
struct Taken {
  double seconds = 0.0, memory_bytes = 0.0, disk_bytes = 0.0;
};

class SavingsLong : public testing::TestWithParam<LeftOutPart> {
protected:
  std::vector<std::string> words(const char* verb, bool with) const {
    std::vector<std::string> words = {verb, write(with)};
    for (const std::string& set : GetParam().sets) {
      if (with)
        words.insert(words.end(), {"--set", set});
    }
    return words;
  }

  nlohmann::json plan(bool with) const {
    std::vector<std::string> asked = words("plan", with);
    asked.insert(asked.end(), {"--json", "--threads", "1"});
    const Outcome outcome = run_wry(asked, m_folder.path());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  }

  Taken run(bool with) const {
    const std::filesystem::path out = m_folder.path() / (with ? "out_with" : "out_without");
    std::vector<std::string> asked = words("simulate", with);
    asked.insert(asked.end(), {"--threads", "1", "--quiet", "--out", out.string()});
    const double before = cpu_seconds_of_children();
    const Outcome outcome = run_wry(asked, m_folder.path());
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return {cpu_seconds_of_children() - before, 0.0, bytes_in(out)};
  }

private:
  std::string write(bool with) const {
    const std::filesystem::path path = m_folder.path() / (with ? "with.toml" : "without.toml");
    write_text(path, GetParam().without + (with ? GetParam().lines : std::string()));
    return path.string();
  }

  TemporaryFolder m_folder;
};

/// The plan of the shot with the part costs what its plan without it says that leaving it out saves.
TEST_P(SavingsLong, AreWhatThePlanWithThePartCostsMore) {
  const nlohmann::json without = plan(false), with = plan(true);
  for (const nlohmann::json& line : without.at("left_out")) {
    if (line.at("what") != GetParam().name)
      continue;
    const nlohmann::json &saving = line.at("saves"), &less = without.at("cost"), &more = with.at("cost");
    for (const char* what : {"seconds", "memory_bytes", "disk_bytes"}) {
      const double difference = more.at(what).get<double>() - less.at(what).get<double>();
      EXPECT_NEAR(saving.at(what).get<double>(), difference,
                  0.1 * std::abs(difference) + 0.01 * less.at(what).get<double>())
          << what;
    }
    return;
  }
  FAIL() << without.at("left_out").dump(1);
}

/// How many times as much time and disk the shot with the part takes, measured, is what was predicted within a factor
/// of two. Of the times themselves PredictionLong judges.
TEST_P(SavingsLong, AreMeasuredWithinAFactorOfTwo) {
  const nlohmann::json without = plan(false);
  nlohmann::json saving;
  for (const nlohmann::json& line : without.at("left_out")) {
    if (line.at("what") == GetParam().name)
      saving = line.at("saves");
  }
  ASSERT_TRUE(saving.is_object());
  const nlohmann::json& cost = without.at("cost");
  const Taken less = run(false), more = run(true);
  const double predicted = 1.0 + saving.at("seconds").get<double>() / cost.at("seconds").get<double>();
  const double predicted_disk = 1.0 + saving.at("disk_bytes").get<double>() / cost.at("disk_bytes").get<double>();
  const double measured = more.seconds / less.seconds, measured_disk = more.disk_bytes / less.disk_bytes;
  fmt::print("{:42} {:5.1f} s without, times {:5.2f}, predicted {:5.2f}   {:5.1f} MB without, times {:5.2f}, predicted "
             "{:5.2f}\n",
             GetParam().name, less.seconds, measured, predicted, 1e-6 * less.disk_bytes, measured_disk, predicted_disk);
  EXPECT_GT(predicted / measured, 0.5);
  EXPECT_LT(predicted / measured, 2.0);
  EXPECT_GT(predicted_disk / measured_disk, 0.5);
  EXPECT_LT(predicted_disk / measured_disk, 2.0);
}

std::string name_of(const testing::TestParamInfo<LeftOutPart>& part) {
  std::string name = part.param.name;
  for (char& letter : name)
    letter = std::isalnum(static_cast<unsigned char>(letter)) != 0 ? letter : '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(Parts, SavingsLong, testing::ValuesIn(parts()), name_of);

} // namespace
} // namespace wry::cli_test
