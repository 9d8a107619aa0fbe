#include <cstdlib>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/layering/include_rules.h"

namespace wry::layering {

namespace {

std::string list(const std::vector<Violation>& violations) {
  std::string text;
  for (const Violation& violation : violations)
    text += violation.file + ":" + std::to_string(violation.line) + ": " + violation.what + "\n";
  return text;
}

/// A small tree of the house's shape, to see that the checker can fail.
class FakeTree : public ::testing::Test {
protected:
  FakeTree() {
    std::string pattern = (std::filesystem::temp_directory_path() / "wry-layering-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr)
      std::abort();
    m_root = pattern;
    put("sim/base/result.h", "#pragma once\n#include <string>\n");
    put("sim/geometry/mesh.h", "// A mesh.\n#pragma once\n\n#include \"sim/base/result.h\"\n");
    put("sim/fem/step.cpp", "#include \"sim/geometry/mesh.h\"\n#include \"sim/base/result.h\"\n");
    put("sim/contact/distance.h", "#pragma once\n");
    put("sim/sim_plan.h", "#pragma once\n#include \"sim/contact/distance.h\"\n");
    put("shots/shot.h", "#pragma once\n#include \"sim/base/result.h\"\n");
    put("render/look.h", "#pragma once\n");
    put("pipeline/cache/frames.h", "#pragma once\n");
    put("pipeline/run/run.h", "#pragma once\n#include \"pipeline/cache/frames.h\"\n#include \"shots/shot.h\"\n");
    put("pipeline/cli/verbs/run_verb.cpp", "#include <hdf5.h>\n#include \"pipeline/run/run.h\"\n");
    put("pipeline/main.cpp", "int main() {}\n");
    put("tests/fem/step_test.cpp", "#include \"render/look.h\"\n#include \"sim/geometry/mesh.h\"\n");
  }
  ~FakeTree() override {
    std::error_code ignored;
    std::filesystem::remove_all(m_root, ignored);
  }

  void put(const std::string& path, const std::string& text) {
    std::filesystem::create_directories((m_root / path).parent_path());
    std::ofstream(m_root / path) << text;
  }

  /// What the checker says when `path` has `text`, which must be one thing about that file.
  std::string objection(const std::string& path, const std::string& text) {
    put(path, text);
    const std::vector<Violation> violations = check_includes(m_root);
    if (violations.size() != 1 || violations[0].file != path)
      return "not one about " + path + ": " + list(violations);
    return std::to_string(violations[0].line) + ": " + violations[0].what;
  }

  std::filesystem::path m_root;
};

} // namespace

TEST(Layering, HoldsInThisProject) {
  ASSERT_GT(count_sources(WRY_SOURCE_DIR), 50u) << "the walk must see the project";
  const std::vector<Violation> violations = check_includes(WRY_SOURCE_DIR);
  EXPECT_TRUE(violations.empty()) << list(violations);
}

TEST_F(FakeTree, IsSound) {
  EXPECT_EQ(list(check_includes(m_root)), "");
  EXPECT_EQ(count_sources(m_root), 12u);
}

TEST_F(FakeTree, ArrowsUpwardsFail) {
  EXPECT_EQ(objection("sim/base/bad.cpp", "\n#include \"sim/geometry/mesh.h\"\n"),
            "2: sim/base may not include sim/geometry/mesh.h");
}

TEST_F(FakeTree, ShotsSeeOnlyTheBase) {
  EXPECT_EQ(objection("shots/bad.cpp", "#include \"sim/geometry/mesh.h\"\n"),
            "1: shots may not include sim/geometry/mesh.h");
}

TEST_F(FakeTree, RenderDoesNotSeeSimulations) {
  EXPECT_EQ(objection("render/passes/bad.cpp", "#include \"sim/contact/distance.h\"\n"),
            "1: render may not include sim/contact/distance.h");
}

TEST_F(FakeTree, TheMethodsDoNotSeeEachOther) {
  put("sim/mpm/grid.h", "#pragma once\n");
  EXPECT_EQ(objection("sim/fem/bad.cpp", "#include \"sim/mpm/grid.h\"\n"), "1: sim/fem may not include sim/mpm/grid.h");
}

TEST_F(FakeTree, MethodsDoNotSeeTheSimPlan) {
  EXPECT_EQ(objection("sim/fem/bad.cpp", "#include \"sim/sim_plan.h\"\n"), "1: sim/fem may not include sim/sim_plan.h");
}

TEST_F(FakeTree, PartsOfThePipelineHaveArrowsToo) {
  EXPECT_EQ(objection("pipeline/cache/bad.cpp", "#  include \"pipeline/run/run.h\"  // upwards\n"),
            "1: pipeline/cache may not include pipeline/run/run.h");
}

TEST_F(FakeTree, UnknownPartsAreNamed) {
  EXPECT_EQ(objection("pipeline/stuff/bad.cpp", "int x;\n"),
            "0: pipeline/stuff is no room that the layering knows: give it a line in ARROWS");
}

TEST_F(FakeTree, IncludesStartAtTheTop) {
  EXPECT_EQ(objection("sim/fem/bad.cpp", "#include \"step.h\"\n"), "1: step.h is no file from the top of the project");
}

TEST_F(FakeTree, HeadersOfOthersStayOutOfOurs) {
  for (const char* name : {"openvdb/openvdb.h", "assimp/scene.h", "hdf5.h", "H5Fpublic.h", "cholmod.h", "GL/osmesa.h",
                           "toml++/toml.h", "toml.hpp", "CLI/CLI.hpp"})
    EXPECT_EQ(objection("pipeline/run/bad.h", "#pragma once\n#include <" + std::string(name) + ">\n"),
              "2: " + std::string(name) + " stays out of our headers: include it in a .cpp");
}

TEST_F(FakeTree, GlStaysBehindItsWall) {
  put("render/gl/functions.h", "#pragma once\n#include <GL/gl.h>\n");
  put("render/draw.cpp", "#include \"render/gl/functions.h\"\n");
  EXPECT_EQ(list(check_includes(m_root)), "");
  EXPECT_EQ(objection("pipeline/cli/bad.cpp", "#include \"render/gl/functions.h\"\n"),
            "1: render/gl/functions.h stays within render");
}

TEST_F(FakeTree, HeadersNeedPragmaOnce) {
  EXPECT_EQ(objection("sim/fem/bad.h", "#include <string>\n"), "0: a header starts with #pragma once");
}

TEST_F(FakeTree, KernelsSeeNoInlineHeavyHeaders) {
  put("sim/fem/batch.h", "#pragma once\n#include \"sim/fem/deep.h\"\n");
  put("sim/fem/deep.h", "#pragma once\n#include <Eigen/Core>\n");
  EXPECT_EQ(objection("sim/fem/a.kernel.cpp", "#include <cmath>\n#include \"sim/fem/batch.h\"\n"),
            "0: a kernel sees <Eigen/Core> through sim/fem/deep.h");
}

} // namespace wry::layering
