#include <gtest/gtest.h>

#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

class BadInput : public testing::Test {
protected:
  Outcome plan(std::string from, const std::string& to) {
    std::string text = small_shot();
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    write_text(m_folder.path() / "bar.toml", text);
    return run_wry({"plan", "bar.toml"}, m_folder.path());
  }
  const TemporaryFolder m_folder;
};

TEST_F(BadInput, APoissonRatioOfAHalfIsRefusedWithItsLineAndInterval) {
  const Outcome outcome = plan("poisson_ratio = 0.3", "poisson_ratio = 0.5");
  EXPECT_EQ(outcome.exit_code, 65);
  EXPECT_NE(outcome.err.find("bar.toml:16:"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("(-1, 0.5)"), std::string::npos) << outcome.err;
}

TEST_F(BadInput, AMisspeltKeyNamesTheNearest) {
  const Outcome outcome = plan("youngs_modulus = 2e4", "young_modulus = 2e4");
  EXPECT_EQ(outcome.exit_code, 65);
  EXPECT_NE(outcome.err.find("youngs_modulus"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("bar.toml:15:"), std::string::npos) << outcome.err;
}

TEST_F(BadInput, ARegionWithoutNodesNamesTheExtents) {
  const Outcome outcome = plan("min = [-0.21, 0, -1], max = [-0.19, 1, 1]", "min = [5, 5, 5], max = [6, 6, 6]");
  EXPECT_EQ(outcome.exit_code, 65);
  EXPECT_NE(outcome.err.find("bar.toml:"), std::string::npos) << outcome.err;
}

TEST_F(BadInput, SingularMicrorotationsAreRefused) {
  const Outcome outcome = plan("length_scale = 0.02", "length_scale = 0\ncouple_modulus_ratio = 0");
  EXPECT_EQ(outcome.exit_code, 65) << outcome.err;
}

TEST_F(BadInput, ARestCurvatureThatHasNoValueIsRefusedWithItsLineAndReason) {
  const auto curved = [&](const std::string& formula) {
    return plan("length_scale = 0.02", "length_scale = 0.02\nrest_curvature = { zx = \"" + formula + "\" }");
  };
  const Outcome unknown = curved("8*quux");
  EXPECT_EQ(unknown.exit_code, 65);
  EXPECT_NE(unknown.err.find("bar.toml:18:"), std::string::npos) << unknown.err;
  EXPECT_NE(unknown.err.find("quux"), std::string::npos) << unknown.err;
  const Outcome not_a_number = curved("ln(X - 5)");
  EXPECT_EQ(not_a_number.exit_code, 65);
  EXPECT_NE(not_a_number.err.find("bar.toml:18:"), std::string::npos) << not_a_number.err;
  EXPECT_NE(not_a_number.err.find("ln(X - 5)"), std::string::npos) << not_a_number.err;
  EXPECT_EQ(curved("8*u + v*t").exit_code, 0) << "a box has coordinates of its own";
}

TEST_F(BadInput, AFactorThatVanishesSomewhereIsRefusedWithThePlace) {
  const Outcome outcome = plan("length_scale = 0.02", "length_scale = 0.02\nvary = { youngs_modulus = \"X\" }");
  EXPECT_EQ(outcome.exit_code, 65);
  EXPECT_NE(outcome.err.find("bar.toml:18:"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("above 0"), std::string::npos) << outcome.err;
}

TEST_F(BadInput, ALoadThatDependsOnThePlaceIsRefused) {
  const Outcome outcome = plan("[render]", "[[load]]\nforce = { x = \"10*Y\" }\n\n[render]");
  EXPECT_EQ(outcome.exit_code, 65);
  EXPECT_NE(outcome.err.find("may depend on t only"), std::string::npos) << outcome.err;
}

TEST_F(BadInput, AMissingShotOrMeshIsMissingInput) {
  EXPECT_EQ(run_wry({"plan", "nowhere.toml"}, m_folder.path()).exit_code, 66);
  const Outcome outcome = plan("box = { size = [0.4, 0.1, 0.1] }", "mesh = \"nowhere.obj\"");
  EXPECT_EQ(outcome.exit_code, 66) << outcome.err;
  EXPECT_NE(outcome.err.find("nowhere.obj"), std::string::npos) << outcome.err;
}

TEST_F(BadInput, AnUnwritableFolderIsFoundBeforeSimulating) {
  write_text(m_folder.path() / "bar.toml", small_shot());
  const Outcome outcome = run_wry({"simulate", "bar.toml", "--out", "/proc/wry"}, m_folder.path());
  EXPECT_EQ(outcome.exit_code, 73) << outcome.err;
  EXPECT_NE(outcome.err.find("/proc/wry"), std::string::npos) << outcome.err;
}

TEST_F(BadInput, AWrongCommandLineIsUsage) {
  EXPECT_EQ(run_wry({"simulat", "bar.toml"}, m_folder.path()).exit_code, 2);
  EXPECT_EQ(run_wry({"plan"}, m_folder.path()).exit_code, 2);
  write_text(m_folder.path() / "bar.toml", small_shot());
  EXPECT_EQ(run_wry({"simulate", "bar.toml", "--frames", "9-1"}, m_folder.path()).exit_code, 2);
  EXPECT_EQ(run_wry({"simulate", "bar.toml", "--set", "no_equals_sign"}, m_folder.path()).exit_code, 2);
}

TEST_F(BadInput, HelpTeachesAndNamesEveryVerb) {
  const Outcome outcome = run_wry({"--help"}, m_folder.path());
  EXPECT_EQ(outcome.exit_code, 0);
  for (const char* verb : {"run", "plan", "simulate", "render", "turntable", "sweep", "check", "list", "schema"})
    EXPECT_NE(outcome.out.find(verb), std::string::npos) << verb;
}

} // namespace
} // namespace wry::cli_test
