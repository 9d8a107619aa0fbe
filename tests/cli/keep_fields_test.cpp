#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

const std::string HEAP = R"([shot]
name = "heap"
frames = "1-5"
[[body]]
name = "heap"
region = { box = { min = [0, 0.05, 0], max = [0.1, 0.15, 0.1] } }
material = "sand"
sub_particles = { per_particle = 2, shape = "rod", size = [0.002, 0.002, 0.01] }
[material.sand]
model = "mpm"
plasticity = "drucker-prager"
youngs_modulus = 5e4
poisson_ratio = 0.3
[mpm]
cell_size = 0.025
keep_fields = true
[[collider]]
name = "floor"
plane = { height = 0 }
[[collider]]
name = "ram"
box = { size = [0.02, 0.1, 0.2] }
translate = [-0.06, 0.05, 0.05]
keys = [{ time = 0 }, { time = 0.2, translate = [0.08, 0, 0] }]
[[measure]]
name = "height"
kind = "pile_height"
body = "heap"
)";

class KeepFields : public testing::Test {
protected:
  void SetUp() override { write_text(m_folder.path() / "heap.toml", HEAP); }
  Outcome simulate(const std::string& name, std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {"simulate", "heap.toml", "--out", out(name).string()};
    words.insert(words.end(), more.begin(), more.end());
    return run_wry(words, m_folder.path());
  }
  fs::path out(const std::string& name) const { return m_folder.path() / name; }
  const TemporaryFolder m_folder;
};

const std::vector<std::string> OTHER = {"--set",
                                        "body.heap.sub_particles={ per_particle = 5, shape = \"card\", size = [0.004, "
                                        "0.006, 0.001], seed = 9 }"};

TEST_F(KeepFields, OtherGrainsAreMadeWithoutSimulatingToTheBitsThatSimulatingGives) {
  ASSERT_EQ(simulate("kept").exit_code, 0);
  const Outcome again = simulate("kept", OTHER);
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("5 frames given other grains from the fields that were kept, without simulating"));
  EXPECT_THAT(again.out, Not(HasSubstr("steps")));
  const Outcome anew = simulate("anew", OTHER);
  ASSERT_EQ(anew.exit_code, 0) << anew.err;
  EXPECT_THAT(anew.out, HasSubstr("5 frames simulated"));
  EXPECT_EQ(frame_hashes(out("kept")), frame_hashes(out("anew")));
  EXPECT_EQ(read_text(out("kept") / "measure.csv"), read_text(out("anew") / "measure.csv"));
  EXPECT_THAT(simulate("kept", OTHER).out, HasSubstr("all 5 frames were there already"));
}

TEST_F(KeepFields, OtherMatterIsSimulated) {
  ASSERT_EQ(simulate("kept").exit_code, 0);
  for (const char* set : {"material.sand.friction_angle=20", "body.heap.sub_particles.travel=0.1"}) {
    const Outcome other = simulate("kept", {"--set", set});
    ASSERT_EQ(other.exit_code, 0) << other.err;
    EXPECT_THAT(other.out, HasSubstr("5 frames simulated")) << set;
  }
  // The frames are now those of other matter: fields of the first are gone, not taken for theirs.
  EXPECT_THAT(simulate("kept", OTHER).out, HasSubstr("5 frames simulated"));
}

TEST_F(KeepFields, DamagedFieldsAreSaidAndMadeAgain) {
  ASSERT_EQ(simulate("kept").exit_code, 0);
  const fs::path file = out("kept") / "fields" / "0003.h5";
  ASSERT_TRUE(fs::exists(file));
  std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(500).write("damage", 6);
  EXPECT_EQ(run_wry({"check", out("kept").string()}, m_folder.path()).exit_code, 1);
  const Outcome again = simulate("kept", OTHER);
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.err, HasSubstr("0003.h5"));
  EXPECT_THAT(again.out, HasSubstr("5 frames simulated"));
  EXPECT_EQ(run_wry({"check", out("kept").string()}, m_folder.path()).exit_code, 0);
}

TEST_F(KeepFields, PlanSaysWhatTheyTakeAndWhatTheySave) {
  const Outcome with = run_wry({"plan", "heap.toml"}, m_folder.path());
  EXPECT_THAT(with.out, HasSubstr("mpm.keep_fields: the grid that carries grains is kept"));
  const Outcome without = run_wry({"plan", "heap.toml", "--set", "mpm.keep_fields=false"}, m_folder.path());
  EXPECT_THAT(without.out, HasSubstr("no mpm.keep_fields: other grains"));
}

} // namespace
} // namespace wry::cli_test
