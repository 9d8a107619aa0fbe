#include <csignal>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/report/csv_table.h"
#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

namespace fs = std::filesystem;

/// A small heap that falls on a floor, and a block that is held: both methods in one shot.
const std::string HEAP = R"([shot]
name = "heap"
frames = "1-7"
[[body]]
name = "heap"
region = { box = { min = [0, 0.05, 0], max = [0.2, 0.25, 0.2] } }
material = "sand"
[material.sand]
model = "mpm"
plasticity = "drucker-prager"
youngs_modulus = 5e4
poisson_ratio = 0.3
plastic_scale = { x = 1, y = 1, z = 1 }
[mpm]
cell_size = 0.05
[[collider]]
name = "floor"
plane = { height = 0 }
[[measure]]
name = "height"
kind = "pile_height"
body = "heap"
)";
const std::string BLOCK = R"([[body]]
name = "block"
box = { size = [0.2, 0.1, 0.1] }
translate = [1, 0.2, 0]
cells = [2, 1, 1]
material = "gum"
[material.gum]
model = "neo-hookean"
youngs_modulus = 1e5
poisson_ratio = 0.4
)";

class MpmRun : public testing::Test {
protected:
  Outcome simulate(const std::string& text, const std::string& name, std::vector<std::string> more = {}) const {
    write_text(m_folder.path() / "heap.toml", text);
    std::vector<std::string> arguments = {"simulate", "heap.toml", "--out", (m_folder.path() / name).string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_wry(arguments, m_folder.path());
  }
  fs::path out(const std::string& name) const { return m_folder.path() / name; }
  const TemporaryFolder m_folder;
};

TEST_F(MpmRun, BothMethodsGoToEveryFrameOfOneShot) {
  const Outcome done = simulate(HEAP + BLOCK, "both");
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_EQ(frame_hashes(out("both")).size(), 7u);
  EXPECT_NE(done.out.find("solids: "), std::string::npos) << done.out;
  EXPECT_NE(done.out.find("particles: "), std::string::npos) << done.out;
  const std::string stats = read_text(out("both") / "stats.csv");
  for (const char* column : {"newton_iterations", "limit", "max_speed_m_per_s"})
    EXPECT_NE(stats.substr(0, stats.find('\n')).find(column), std::string::npos) << column;
}

TEST_F(MpmRun, OfOneMethodAloneHasNoColumnsOfTheOther) {
  ASSERT_EQ(simulate(HEAP, "alone").exit_code, 0);
  const std::string stats = read_text(out("alone") / "stats.csv");
  EXPECT_EQ(stats.substr(0, stats.find('\n')).find("newton"), std::string::npos);
}

TEST_F(MpmRun, GoesOnFromACheckpointToTheSameBits) {
  ASSERT_EQ(simulate(HEAP + BLOCK, "whole", {"--threads", "1"}).exit_code, 0);
  ASSERT_EQ(simulate(HEAP + BLOCK, "parts", {"--frames", "1-3"}).exit_code, 0);
  const Outcome rest = simulate(HEAP + BLOCK, "parts", {"--threads", "3"});
  ASSERT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_NE(rest.out.find("resumed from frame 3"), std::string::npos) << rest.out;
  EXPECT_EQ(frame_hashes(out("parts")), frame_hashes(out("whole")));
  EXPECT_EQ(read_text(out("parts") / "measure.csv"), read_text(out("whole") / "measure.csv"));
}

TEST_F(MpmRun, AHandGivenStepThatIsUnstableIsCutAndSaidSo) {
  const Outcome done = simulate(HEAP, "cut", {"--set", "mpm.time_step=0.02"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_NE(done.out.find("mpm.time_step was unstable and cut"), std::string::npos) << done.out;
}

TEST_F(MpmRun, PlanSaysWhatAParticleCarriesAndWhatIsLeftOut) {
  write_text(m_folder.path() / "heap.toml", HEAP);
  const Outcome plan = run_wry({"plan", "heap.toml"}, m_folder.path());
  ASSERT_EQ(plan.exit_code, 0) << plan.err;
  for (const char* part : {"512 particles of 124 bytes", "position 12, velocity 12, affine 36, deformation 36",
                           "isotropic: no maps", "no [[fixed]] or [[drive]] on a body of particles", "fem"})
    EXPECT_NE(plan.out.find(part), std::string::npos) << part << "\n" << plan.out;
}

const std::string LIFT = R"([[drive]]
name = "lift"
where = { box = { min = [-1, 0.2, -1], max = [1, 1, 1] } }
keys = [{ time = 0 }, { time = 0.25, translate = [0, 0.25, 0] }]
)";

TEST_F(MpmRun, DrivenSpaceTakesTheMatterInItAlong) {
  ASSERT_EQ(simulate(HEAP + LIFT, "lifted").exit_code, 0);
  const std::string measured = read_text(out("lifted") / "measure.csv");
  const auto height = [&](std::size_t line_start) {
    return std::stod(measured.substr(measured.find(',', measured.find(',', line_start) + 1) + 1));
  };
  const double first = height(measured.find('\n') + 1);
  const double last = height(measured.rfind('\n', measured.size() - 2) + 1);
  EXPECT_NEAR(last - first, 0.25, 0.005) << measured;
}

TEST_F(MpmRun, SpringsOnParticlesAreRefusedWithTheirLine) {
  write_text(m_folder.path() / "heap.toml", HEAP + LIFT + "method = \"penalty\"\n");
  const Outcome plan = run_wry({"plan", "heap.toml"}, m_folder.path());
  EXPECT_EQ(plan.exit_code, 65);
  EXPECT_NE(plan.err.find("heap.toml:27:10"), std::string::npos) << plan.err;
  EXPECT_NE(plan.err.find("particles are driven through their grid"), std::string::npos) << plan.err;
}

TEST_F(MpmRun, AccuracyTellsWhatSinglePrecisionIsWorth) {
  write_text(m_folder.path() / "heap.toml", HEAP);
  const Outcome told = run_wry({"accuracy", "heap.toml", "--frames", "1-3", "--out", "o"}, m_folder.path());
  ASSERT_EQ(told.exit_code, 0) << told.err << told.out;
  const pipeline::CsvTable table = pipeline::read_csv_table(m_folder.path() / "o" / "accuracy" / "accuracy.csv");
  const std::vector<double> errors = table.numbers("height_error"), positions = table.numbers("position_error");
  ASSERT_EQ(errors.size(), 1u) << told.out;
  ASSERT_EQ(positions.size(), 1u) << told.out;
  EXPECT_LT(errors[0], 1e-3);
  EXPECT_GT(positions[0], 0.0); // they are not the same run
  EXPECT_LT(positions[0], 1e-3);
}

TEST_F(MpmRun, SemiImplicitStepsAreInThePlanAndInTheStatistics) {
  write_text(m_folder.path() / "heap.toml", HEAP);
  const std::vector<std::string> sets = {"--set", "material.sand.plasticity=none",
                                         "--set", "material.sand.poisson_ratio=0",
                                         "--set", "material.sand.youngs_modulus={ x = 1e4, y = 1e4, z = 1e8 }",
                                         "--set", "mpm.semi_implicit.courant=10"};
  const auto with_sets = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), sets.begin(), sets.end());
    return arguments;
  };
  const Outcome plan = run_wry(with_sets({"plan", "heap.toml"}), m_folder.path());
  ASSERT_EQ(plan.exit_code, 0) << plan.err;
  EXPECT_NE(plan.out.find("waves may cross 10 cells in a step"), std::string::npos) << plan.out;
  ASSERT_EQ(simulate(HEAP, "fibres", sets).exit_code, 0);
  const pipeline::CsvTable stats = pipeline::read_csv_table(out("fibres") / "stats.csv");
  double iterations = 0.0;
  for (const double of_step : stats.numbers("linear_iterations"))
    iterations += of_step;
  EXPECT_GT(iterations, 0.0);
  EXPECT_LT(stats.rows.size(), 700u); // explicit steps would be 25 times as many
  const Outcome without = run_wry({"plan", "heap.toml"}, m_folder.path());
  EXPECT_NE(without.out.find("no mpm.semi_implicit: no linear solve on the grid"), std::string::npos) << without.out;
  const Outcome bad = run_wry({"plan", "heap.toml", "--set", "mpm.semi_implicit.implicitness=0.1"}, m_folder.path());
  EXPECT_EQ(bad.exit_code, 65);
  EXPECT_NE(bad.err.find("implicitness"), std::string::npos) << bad.err;
}

struct Refused {
  const char *set, *expected;
};

TEST_F(MpmRun, BadInputIsSaidBeforeAnythingRuns) {
  write_text(m_folder.path() / "heap.toml", HEAP);
  for (const Refused& bad : {
           Refused{"material.sand.poisson_ratio={ yz = 0.9, xz = 0.9, xy = 0.3 }", "expected"},
           Refused{"body.heap.fibre={ expression = { x = \"0*X\" } }", "no length"},
           Refused{"body.heap.fibre={ expression = { x = \"0/0\" } }", "is no number"},
           Refused{"body.heap.fibre={ direction = [0, 0, 0] }", "expected"},
           Refused{"body.heap.fibre={ direction = [nan, 0, 1] }", "expected"},
           Refused{"body.heap.region={ sphere = { centre = [0, 1, 0], radius = 1e-3 }, expression = \"X > 5\" }",
                   "no particle fits"},
           Refused{"mpm.cell_size=1e-6", "this machine has room for"},
       }) {
    const Outcome plan = run_wry({"plan", "heap.toml", "--set", bad.set}, m_folder.path());
    EXPECT_TRUE(plan.exit_code == 65 || plan.exit_code == 71) << bad.set << " " << plan.exit_code;
    EXPECT_NE(plan.err.find(bad.expected), std::string::npos) << plan.err;
    EXPECT_NE(plan.err.find("heap"), std::string::npos) << plan.err;
  }
}

TEST_F(MpmRun, OverlapAndHydrostaticFlowAreWarnedOf) {
  const Outcome soft = simulate(HEAP, "soft", {"--frames", "1", "--set", "material.sand.plastic_scale.z=2"});
  EXPECT_NE(soft.err.find("warning"), std::string::npos) << soft.err;
  const std::string twice = HEAP + R"([[body]]
name = "twin"
region = { box = { min = [0.1, 0.1, 0.1], max = [0.3, 0.3, 0.3] } }
material = "sand"
)";
  const Outcome overlap = simulate(twice, "overlap", {"--frames", "1"});
  EXPECT_NE(overlap.err.find("matter is there twice"), std::string::npos) << overlap.err;
}

TEST_F(MpmRun, StoppedBetweenFramesItGoesOnToTheSameBits) {
  const std::string finer = HEAP + "\n";
  ASSERT_EQ(simulate(finer, "straight", {"--set", "mpm.cell_size=0.025"}).exit_code, 0);
  const Outcome stopped =
      run_wry_and_signal({"simulate", "heap.toml", "--out", out("stopped").string(), "--set", "mpm.cell_size=0.025"},
                         m_folder.path(), SIGTERM, 60);
  EXPECT_TRUE(stopped.exit_code == 75 || stopped.exit_code == 0 || stopped.exit_code == 128 + SIGTERM)
      << stopped.exit_code << stopped.err;
  ASSERT_EQ(simulate(finer, "stopped", {"--set", "mpm.cell_size=0.025"}).exit_code, 0);
  EXPECT_EQ(frame_hashes(out("stopped")), frame_hashes(out("straight")));
}

} // namespace
} // namespace wry::cli_test
