#include "shots/resolved.h"

#include <algorithm>

#include "tests/shots/shots_support.h"

namespace wry::shots {
namespace {

std::vector<std::string> as_text(const std::vector<FlatKey>& keys) {
  std::vector<std::string> lines;
  for (const FlatKey& key : keys) {
    lines.push_back(key.key + " = " + key.value + " " + std::to_string(static_cast<int>(key.effect)));
  }
  return lines;
}

Effect effect_of(const Shot& shot, const std::string& name) {
  for (const FlatKey& key : flatten(shot)) {
    if (key.key == name) {
      return key.effect;
    }
  }
  ADD_FAILURE() << "no key " << name;
  return Effect::nothing;
}

TEST(Resolved, ReadsBackAsTheSameShot) {
  for (const char* change :
       {"shot.fps=25", "render.camera={ azimuth_deg = 12 }", "case=stiff", "body.wide.box={ size = [2, 2, 2] }"}) {
    const Result<Shot> shot = load_shot(data_file("every_key.toml"), {*parse_override(change)});
    ASSERT_TRUE(shot.ok()) << shot.error().message;
    const Result<ShotDocument> document = read_document_text(write_resolved(*shot), shot->file, shot->directory);
    ASSERT_TRUE(document.ok()) << document.error().message;
    const Result<Shot> again = make_shot(*document);
    ASSERT_TRUE(again.ok()) << again.error().message;
    EXPECT_EQ(as_text(flatten(*shot)), as_text(flatten(*again))) << change;
    EXPECT_EQ(write_resolved(*shot), write_resolved(*again));
    EXPECT_EQ(shot->sweep_case.has_value(), again->sweep_case.has_value());
  }
}

TEST(Resolved, KeepsEveryDigit) {
  const Result<Shot> shot = load_text(replaced(SMALL_SHOT, "0.4", "0.12345678901234567"));
  const Result<Shot> again = load_text(write_resolved(*shot));
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(*again->materials[0].poisson_ratio, 0.12345678901234567);
}

TEST(Resolved, PathsFollowTheTextToItsFolder) {
  const std::string text = replaced(SMALL_SHOT, "box = { size = [1, 1, 1] }", "mesh = \"meshes/a \\\"b\\\".obj\"");
  const Result<ShotDocument> document = read_document_text(text, "shots/t.toml", "shots");
  const Result<Shot> shot = make_shot(*document);
  ASSERT_TRUE(shot.ok()) << shot.error().message;
  const std::string moved = write_resolved(*shot, "out/small");
  EXPECT_THAT(moved, testing::HasSubstr("mesh = \"../../shots/meshes/a \\\"b\\\".obj\""));
  const Result<ShotDocument> stored = read_document_text(moved, "out/small/shot.toml", "out/small");
  EXPECT_EQ(*std::get<MeshShape>(make_shot(*stored)->bodies[0].shape).path, "shots/meshes/a \"b\".obj");
}

TEST(Resolved, EveryKeyHasItsEffect) {
  const Result<Shot> shot = load_shot(data_file("every_key.toml"));
  EXPECT_EQ(effect_of(*shot, "body.from_mesh.resolution"), Effect::simulation);
  EXPECT_EQ(effect_of(*shot, "material.skin.curvature.stiffness.yy"), Effect::simulation);
  EXPECT_EQ(effect_of(*shot, "fem.newton_tolerance"), Effect::simulation);
  EXPECT_EQ(effect_of(*shot, "shot.gravity"), Effect::simulation);
  EXPECT_EQ(effect_of(*shot, "body.from_mesh.look"), Effect::pictures);
  EXPECT_EQ(effect_of(*shot, "look.rubber.colour"), Effect::pictures);
  EXPECT_EQ(effect_of(*shot, "render.camera.lens"), Effect::pictures);
  EXPECT_EQ(effect_of(*shot, "render.heat.speed.max"), Effect::pictures);
  EXPECT_EQ(effect_of(*shot, "measure.tip.where.expression"), Effect::nothing);
  EXPECT_EQ(effect_of(*shot, "fem.keep"), Effect::nothing);
  EXPECT_EQ(effect_of(*shot, "shot.frames"), Effect::nothing) << "a longer shot keeps its frames";
  EXPECT_EQ(effect_of(*shot, "shot.frames.first"), Effect::simulation);
  EXPECT_EQ(effect_of(*load_with("[material.spare]\npreset = \"felt\"\n"), "material.spare.density"), Effect::nothing)
      << "a material that no body has";
}

TEST(Resolved, ComparingNamesTheKeysThatChanged) {
  const Result<Shot> before = load_with("");
  const Result<Shot> after =
      load_with("[look.red]\n", {*parse_override("material.skin.density=900"), *parse_override("body.block.look=red")});
  ASSERT_TRUE(after.ok()) << after.error().message;
  const std::vector<KeyChange> changes = compare(flatten(*before), flatten(*after));
  const auto density =
      std::find_if(changes.begin(), changes.end(), [](const KeyChange& c) { return c.key == "material.skin.density"; });
  ASSERT_NE(density, changes.end());
  EXPECT_EQ(density->before, "1000.0");
  EXPECT_EQ(density->after, "900.0");
  EXPECT_EQ(density->effect, Effect::simulation);
  EXPECT_EQ(
      std::count_if(changes.begin(), changes.end(), [](const KeyChange& c) { return c.effect == Effect::simulation; }),
      1);
  EXPECT_TRUE(compare(flatten(*before), flatten(*before)).empty());
  EXPECT_EQ(compare(flatten(*after), flatten(*before)).size(), changes.size());
}

} // namespace
} // namespace wry::shots
