#include "tests/shots/shots_support.h"

namespace wry::shots {
namespace {

using testing::HasSubstr;

Override set(const std::string& text) {
  const Result<Override> change = parse_override(text);
  EXPECT_TRUE(change.ok()) << text;
  return *change;
}

TEST(Overrides, ReachAnyKey) {
  const Result<Shot> shot = load_with("[[collider]]\nplane = {}\n",
                                      {set("material.skin.youngs_modulus=1e5"), set("body.block.resolution=0.02"),
                                       set("collider.collider1.friction=0.1"), set("shot.frames=1001-1010x3"),
                                       set("material.skin.model=neo-hookean"), set("render.views=[\"clay\"]"),
                                       set("shot.gravity=[0, -1.62, 0]"), set("render.camera.azimuth_deg = 90")});
  ASSERT_TRUE(shot.ok()) << shot.error().message;
  EXPECT_EQ(*shot->materials[0].youngs_modulus, 1e5);
  EXPECT_EQ(shot->materials[0].youngs_modulus.source.origin, Origin::command_line);
  EXPECT_EQ(**shot->bodies[0].resolution, 0.02);
  EXPECT_EQ(*shot->colliders[0].friction, 0.1) << "things without a name have fixed1, collider1, ...";
  EXPECT_EQ(shot->shot.frames->count(), 4u);
  EXPECT_EQ(*shot->materials[0].model, MaterialModel::neo_hookean);
  EXPECT_EQ(shot->render.views[0]->kind, ViewKind::clay);
  EXPECT_EQ((*shot->shot.gravity)[1], -1.62);
  EXPECT_EQ(*shot->render.camera.azimuth_deg, 90.0);
}

TEST(Overrides, TheLastOneWins) {
  EXPECT_EQ(*load_with("", {set("shot.fps=25"), set("shot.fps=30")})->shot.fps, 30.0);
}

TEST(Overrides, BareWordsAndNumbersBecomeTextWhereTextIsWanted) {
  const Result<Shot> shot = load_with("", {set("shot.name=2024"), set("shot.frames=7")});
  ASSERT_TRUE(shot.ok()) << shot.error().message;
  EXPECT_EQ(*shot->shot.name, "2024");
  EXPECT_EQ(shot->shot.frames->first(), 7);
}

TEST(Overrides, AnotherShapeReplacesTheOneOfTheFile) {
  const Result<Shot> shot = load_with("", {set("body.block.sphere={ radius = 2 }")});
  ASSERT_TRUE(shot.ok()) << shot.error().message;
  EXPECT_TRUE(std::holds_alternative<SphereShape>(shot->bodies[0].shape));
}

TEST(Overrides, ErrorsSaySet) {
  EXPECT_EQ(refusal(load_with("", {set("material.skin.youngs_modulus=-5")})),
            "--set: material.skin.youngs_modulus = -5: expected a positive modulus in Pa");
  EXPECT_EQ(
      refusal(load_with("", {set("material.skin.yungs_modulus=5")})),
      "--set: material.skin.yungs_modulus: there is no such key in material.skin; did you mean 'youngs_modulus'?");
  EXPECT_THAT(refusal(load_with("", {set("body.blok.resolution=1")})),
              HasSubstr("no [[body]] named 'blok'; did you mean 'block'?"));
  EXPECT_THAT(refusal(load_with("", {set("shot.name.x=1")})), HasSubstr("shot.name is text, so it has no 'x'"));
  EXPECT_THAT(refusal(load_with("", {set("shot..x=1")})), HasSubstr("empty part"));
  EXPECT_THAT(refusal(load_with("", {set("extends=other.toml")})), HasSubstr("cannot be set"));
  EXPECT_THAT(refusal(load_with("", {set("material.skni.density=1")})), HasSubstr("material.skni.model is missing"));
}

TEST(Overrides, AValueCannotSmuggleInOtherKeys) {
  const Result<Shot> shot = load_with("", {Override{"shot.name", "\"a\"\nfps = 1", {}}});
  EXPECT_FALSE(shot.ok());
  EXPECT_THAT(refusal(shot), HasSubstr("shot.name"));
}

TEST(Overrides, AreKeyAndValue) {
  for (const char* text : {"", "x", "=1", "x=", " = ", "shot.fps 3"}) {
    const Result<Override> change = parse_override(text);
    ASSERT_FALSE(change.ok()) << text;
    EXPECT_EQ(change.error().code, ErrorCode::usage);
  }
  EXPECT_EQ(set("a.\"b=c\"=d=e").key, "a.\"b=c\"");
  EXPECT_EQ(set("a.\"b=c\"=d=e").value, "d=e");
}

} // namespace
} // namespace wry::shots
