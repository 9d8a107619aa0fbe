#include <filesystem>
#include <fstream>

#include "shots/resolved.h"
#include "tests/shots/shots_support.h"

namespace wry::shots {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

/// A folder of its own for each test.
class Extends : public testing::Test {
protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    m_folder = fs::path(testing::TempDir()) / (std::string("wry_extends_") + info->name());
    fs::remove_all(m_folder);
    fs::create_directories(m_folder / "library");
  }
  void TearDown() override { fs::remove_all(m_folder); }

  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(m_folder / name) << text;
    return (m_folder / name).string();
  }
  std::string path(const std::string& name) const { return (m_folder / name).string(); }

  fs::path m_folder;
};

TEST_F(Extends, TheFileWinsOverWhatItExtends) {
  write("base.toml", std::string(SMALL_SHOT) + "density = 900\n[render]\nsamples = 2\nslate = true\n");
  const std::string file = write("shot.toml", R"(extends = "base.toml"
[material.skin]
density = 800
[[body]]
name = "block"
resolution = 0.2
[[body]]
name = "second"
sphere = { radius = 1 }
resolution = 0.1
material = "skin"
[render]
samples = 3
)");
  const Result<Shot> shot = load_shot(file);
  ASSERT_TRUE(shot.ok()) << shot.error().message;
  EXPECT_EQ(*shot->materials[0].density, 800.0);
  EXPECT_EQ(*shot->materials[0].youngs_modulus, 5e4);
  EXPECT_THAT(shot->materials[0].youngs_modulus.source.file, HasSubstr("base.toml"));
  ASSERT_EQ(shot->bodies.size(), 2u);
  EXPECT_EQ(**shot->bodies[0].resolution, 0.2) << "array tables are merged by name";
  EXPECT_EQ(*shot->bodies[1].name, "second");
  EXPECT_EQ(*shot->render.samples, 3);
  EXPECT_TRUE(*shot->render.slate);
}

TEST_F(Extends, AnotherShapeReplacesTheInheritedOne) {
  write("base.toml", SMALL_SHOT);
  const Result<Shot> shot = load_shot(write("shot.toml", "extends = \"base.toml\"\n[[body]]\nname = \"block\"\n"
                                                         "sphere = { radius = 1 }\n"));
  ASSERT_TRUE(shot.ok()) << shot.error().message;
  EXPECT_TRUE(std::holds_alternative<SphereShape>(shot->bodies[0].shape));
}

TEST_F(Extends, PathsAreRelativeToTheFileTheyStandIn) {
  write("library/base.toml", replaced(SMALL_SHOT, "box = { size = [1, 1, 1] }", "mesh = \"meshes/a.obj\""));
  const Result<Shot> shot = load_shot(write("shot.toml", "extends = \"library/base.toml\"\n"));
  ASSERT_TRUE(shot.ok()) << shot.error().message;
  EXPECT_EQ(*std::get<MeshShape>(shot->bodies[0].shape).path, path("library/meshes/a.obj"));
  for (const FlatKey& key : flatten(*shot)) {
    if (key.key == "body.block.mesh") {
      EXPECT_EQ(key.value, "\"library/meshes/a.obj\"") << "the same wherever the folder stands";
    }
  }
}

TEST_F(Extends, CirclesMissingFilesAndLongChainsAreErrors) {
  write("a.toml", "extends = \"b.toml\"\n");
  write("b.toml", "extends = \"library/../a.toml\"\n");
  EXPECT_THAT(refusal(load_shot(path("a.toml"))), HasSubstr("in a circle"));
  EXPECT_THAT(refusal(load_shot(write("self.toml", "extends = \"self.toml\"\n"))), HasSubstr("in a circle"));
  const Result<Shot> missing = load_shot(write("m.toml", "\nextends = \"gone.toml\"\n"));
  EXPECT_EQ(missing.error().code, ErrorCode::missing_input);
  EXPECT_THAT(missing.error().message, HasSubstr("m.toml:2:11: extends = \"gone.toml\": "));
  for (int i = 0; i < 12; ++i) {
    write(fmt::format("c{}.toml", i), fmt::format("extends = \"c{}.toml\"\n", i + 1));
  }
  EXPECT_THAT(refusal(load_shot(path("c0.toml"))), HasSubstr("more than 8 files"));
  EXPECT_THAT(refusal(load_shot(write("n.toml", "extends = 3\n"))), HasSubstr("this is an integer; expected the path"));
  EXPECT_THAT(refusal(load_shot(write("d.toml", "extends = \"library\"\n"))), HasSubstr("this is no file"));
}

TEST_F(Extends, ErrorsNameTheFileTheyAreIn) {
  write("base.toml", replaced(SMALL_SHOT, "5e4", "-5"));
  EXPECT_THAT(
      refusal(load_shot(write("shot.toml", "extends = \"base.toml\"\n[shot]\nfps = 0\n"))),
      testing::AllOf(HasSubstr("base.toml:12:18: material.skin.youngs_modulus"), HasSubstr("shot.toml:3:7: shot.fps")));
}

} // namespace
} // namespace wry::shots
