#include <string>

#include <gtest/gtest.h>

#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

/// `wry plan` of a body made of this OBJ text.
Outcome plan_mesh(const std::string& obj) {
  const TemporaryFolder folder;
  write_text(folder.path() / "mesh.obj", obj);
  write_text(folder.path() / "shot.toml", "[[body]]\nname = \"thing\"\nmesh = \"mesh.obj\"\nresolution = 0.3\n"
                                          "material = \"soft\"\n[material.soft]\npreset = \"gel\"\n");
  return run_wry({"plan", "shot.toml"}, folder.path());
}

TEST(Mesh, AnOpenOneNamesItsHole) {
  const Outcome outcome = plan_mesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n");
  EXPECT_EQ(outcome.exit_code, 65) << outcome.err;
  EXPECT_NE(outcome.err.find("shot.toml:1:"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("not closed: 1 hole"), std::string::npos) << outcome.err;
}

TEST(Mesh, ATruncatedOneIsRefused) {
  const Outcome outcome = plan_mesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 3 2\nf 1 2 4\n");
  EXPECT_EQ(outcome.exit_code, 65) << outcome.err;
  EXPECT_NE(outcome.err.find("mesh.obj"), std::string::npos) << outcome.err;
}

} // namespace
} // namespace wry::cli_test
