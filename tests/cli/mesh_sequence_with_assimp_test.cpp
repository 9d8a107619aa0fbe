#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cli/program_support.h"

namespace wry::cli_test {
namespace {

using ::testing::HasSubstr;

/// A level sheet in centimetres, z up: two triangles whose corners are listed against the order of the faces.
std::string sheet(double height) {
  return fmt::format("v -40 40 {0}\nv 40 40 {0}\nv 40 -40 {0}\nv -40 -40 {0}\nf 4 3 2\nf 4 2 1\n", height);
}

/// A box that falls from 2 cm onto a sheet that rises by 5 cm per frame.
class MeshSequence : public ::testing::Test {
protected:
  MeshSequence() {
    write_text(m_folder.path() / "sheet.obj", sheet(0.0));
    for (int frame = 1; frame <= 5; ++frame)
      write_text(m_folder.path() / fmt::format("sheet.{:02}.obj", frame), sheet(5.0 * (frame - 1)));
  }
  void write_shot(const std::string& sequence, int last, const std::string& more = "") const {
    write_text(
        m_folder.path() / "lift.toml",
        fmt::format("[shot]\nframes = \"1-{}\"\n[[body]]\nname = \"box\"\nbox = {{ size = [0.1, 0.1, 0.1] }}\n"
                    "translate = [0.02, 0.07, 0.03]\nresolution = 0.05\nmaterial = \"soft\"\n"
                    "[material.soft]\npreset = \"rubber\"\n[[collider]]\nname = \"sheet\"\nmesh = \"sheet.obj\"\n"
                    "units = \"cm\"\nup = \"z\"\nsequence = \"{}\"\n{}"
                    "[[measure]]\nname = \"lowest\"\nkind = \"lowest\"\n",
                    last, sequence, more));
  }
  Outcome wry(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin() + 1, "lift.toml");
    return run_wry(arguments, m_folder.path());
  }
  TemporaryFolder m_folder;
};

TEST_F(MeshSequence, LiftsABodyAndIsDrawnAndExportedWhereItIs) {
  write_shot("sheet.##.obj", 5);
  const Outcome simulated = wry({"simulate", "--out", "o"});
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  const Outcome exported = wry({"export", "--out", "o", "--to", "obj"});
  ASSERT_EQ(exported.exit_code, 0) << exported.err;
  const std::string last = read_text(m_folder.path() / "o" / "exports" / "obj" / "sheet.0005.obj");
  EXPECT_THAT(last, HasSubstr(" 0.2000")) << "5 cm in each of four frames, upright and in metres";
  const std::string box = read_text(m_folder.path() / "o" / "exports" / "obj" / "box.0005.obj");
  std::size_t below = 0;
  for (std::size_t at = box.find("\nv "); at != std::string::npos; at = box.find("\nv ", at + 1)) {
    double x = 0.0, y = 0.0;
    ASSERT_EQ(std::sscanf(box.c_str() + at, "\nv %lf %lf", &x, &y), 2);
    below += y < 0.2 ? 1 : 0;
  }
  EXPECT_EQ(below, 0u) << "nothing of the box is under the sheet";
}

TEST_F(MeshSequence, IsHeldAgainstTheShot) {
  write_shot("sheet.##.obj", 6);
  const Outcome missing = wry({"plan"});
  EXPECT_EQ(missing.exit_code, 66) << missing.err;
  EXPECT_THAT(missing.err, HasSubstr("lift.toml:16"));
  EXPECT_THAT(missing.err, HasSubstr("sheet.06.obj for frame 6"));

  write_text(m_folder.path() / "sheet.03.obj", sheet(1.0) + "v 0 0 0\n");
  write_shot("sheet.##.obj", 5);
  const Outcome changed = wry({"plan"});
  EXPECT_EQ(changed.exit_code, 65) << changed.err;
  EXPECT_THAT(changed.err, HasSubstr("has 5 vertices, the mesh"));

  write_shot("sheet.##.obj", 2, "node = \"bed\"\n");
  const Outcome node = wry({"plan"});
  EXPECT_EQ(node.exit_code, 65) << node.err;
  EXPECT_THAT(node.err, HasSubstr("remove node"));

  write_shot("sheet.##.obj", 2, "[[drive]]\nwhere = { expression = \"Y > 0.1\" }\ncollider = \"sheet\"\n");
  const Outcome drive = wry({"plan"});
  EXPECT_EQ(drive.exit_code, 65) << drive.err;
  EXPECT_THAT(drive.err, HasSubstr("deforms by its sequence"));
}

} // namespace
} // namespace wry::cli_test
