#include "shots/load.h"

#include <fstream>

#include "tests/shots/shots_support.h"

namespace wry::shots {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

TEST(Load, ReadsEveryKeyAsItWasWritten) {
  const Result<Shot> shot = load_shot(data_file("every_key.toml"));
  ASSERT_TRUE(shot.ok()) << shot.error().message;
  EXPECT_EQ(*shot->shot.name, "every.key");
  EXPECT_EQ(shot->shot.frames->count(), 25u);
  EXPECT_DOUBLE_EQ((*shot->shot.gravity)[2], -1.62);
  EXPECT_EQ(*shot->shot.up, Axis::z);
  ASSERT_EQ(shot->bodies.size(), 10u);
  const Body& body = shot->bodies[0];
  EXPECT_THAT(*std::get<MeshShape>(body.shape).path, testing::EndsWith("shots/meshes/thing.obj"));
  EXPECT_EQ(body.size->measure, SizeMeasure::height);
  EXPECT_DOUBLE_EQ(*body.metres_per_unit, 0.01);
  ASSERT_EQ(body.rotate.size(), 2u);
  EXPECT_EQ(*body.rotate[0].axis, Vec3(0, 1, 0));
  EXPECT_EQ(*body.shell->layers, 3);
  EXPECT_EQ(**shot->bodies[1].cells, (std::array<std::int64_t, 3>{2, 4, 6}));
  EXPECT_EQ(*shot->bodies[1].split, CellSplit::kuhn);
  EXPECT_DOUBLE_EQ(*std::get<TorusShape>(shot->bodies[6].shape).tube_radius, 0.2);
}

TEST(Load, ReadsMaterialsWithCurvature) {
  const Result<Shot> shot = load_shot(data_file("every_key.toml"));
  const Material& skin = *shot->find_material("skin");
  EXPECT_EQ(*skin.model, MaterialModel::micropolar_det);
  EXPECT_DOUBLE_EQ(*skin.curvature.stiffness[1][1], 20.0);
  EXPECT_DOUBLE_EQ(*skin.curvature.stiffness[2][0], 6.0);
  EXPECT_EQ(skin.curvature.basis->col(0), Vec3(0, 1, 0)) << "each list is an axis, a column";
  EXPECT_EQ(skin.rest_curvature[2][0]->value.text, "8*smoothstep(0, 2, t)");
  EXPECT_FALSE(skin.rest_curvature[2][0]->value.constant);
  EXPECT_EQ(skin.rest_curvature[2][1]->value.constant, 7.0);
  EXPECT_TRUE(skin.has_rest_curvature());
  EXPECT_FALSE(shot->find_material("plain")->has_rest_curvature());
}

TEST(Load, ReadsTheSceneAroundTheBodies) {
  const Result<Shot> shot = load_shot(data_file("every_key.toml"));
  EXPECT_TRUE(*shot->fixed[0].hold_positions);
  EXPECT_FALSE(*shot->fixed[0].hold_microrotations);
  EXPECT_DOUBLE_EQ(**shot->fixed[0].until, 1.5);
  EXPECT_DOUBLE_EQ(*std::get<CylinderRegion>(shot->fixed[2].where).radius, 0.1);
  EXPECT_EQ(*std::get<AttributeRegion>(shot->fixed[4].where).attribute, "pinned");
  EXPECT_EQ(*std::get<PlaneShape>(shot->colliders[0].shape).point, Vec3(0, 0, -0.5)) << "height along the normal";
  EXPECT_NEAR((*shot->looks[0].colour)[1], 0x66 / 255.0, 1e-12);
  EXPECT_EQ(shot->render.views[2]->channel, "speed");
  EXPECT_DOUBLE_EQ(**shot->fem.time_step, 0.005);
  EXPECT_EQ(**shot->render.turntable.frame, 1003);
  EXPECT_DOUBLE_EQ(**shot->render.heat[0].max, 3.0);
  EXPECT_EQ(**shot->expectations[1].ratio_to, "soft");
}

TEST(Load, FillsDefaultsAndSaysThatNobodyAskedForThem) {
  const Result<Shot> shot = load_with("[[collider]]\nplane = {}\n[[fixed]]\nwhere = { expression = \"Y < 0.1\" }\n");
  ASSERT_TRUE(shot.ok()) << shot.error().message;
  EXPECT_EQ(*shot->shot.gravity, Vec3(0, -9.81, 0));
  EXPECT_FALSE(shot->shot.gravity.given());
  EXPECT_FALSE(shot->fem.time_step) << "auto";
  EXPECT_EQ(*shot->colliders[0].name, "collider1");
  EXPECT_EQ(*std::get<PlaneShape>(shot->colliders[0].shape).normal, Vec3(0, 1, 0));
  EXPECT_EQ(*shot->fixed[0].body, "block") << "the only body";
  EXPECT_DOUBLE_EQ(*shot->bodies[0].scale, 1.0);
}

TEST(Load, GravityAndPlanesFollowUp) {
  const Result<Shot> shot =
      load_text(replaced(SMALL_SHOT, "name = \"small\"", "up = \"z\"") + "[[collider]]\nplane = {}\n");
  ASSERT_TRUE(shot.ok()) << shot.error().message;
  EXPECT_EQ(*shot->shot.gravity, Vec3(0, 0, -9.81));
  EXPECT_EQ(*std::get<PlaneShape>(shot->colliders[0].shape).normal, Vec3(0, 0, 1));
  EXPECT_EQ(*shot->shot.name, "t") << "from the file's name";
}

TEST(Load, RemembersWhereAValueStood) {
  const Result<Shot> shot = load_with("");
  const Source& source = shot->materials[0].youngs_modulus.source;
  EXPECT_EQ(source.text(), "t.toml:12:18: material.skin.youngs_modulus");
  EXPECT_EQ(source.origin, Origin::file);
  EXPECT_EQ(shot->bodies[0].source.key, "body.block");
  EXPECT_EQ(shot->bodies[0].source.line, 4);
}

TEST(Load, NamesTheNearestKey) {
  EXPECT_EQ(refusal(load_with("denisty = 900\n")),
            "t.toml:14:1: material.skin.denisty: there is no such key in material.skin; did you mean 'density'?");
  EXPECT_THAT(refusal(load_with("[rendr]\n")), AllOf(StartsWith("t.toml:14:2: rendr"), HasSubstr("'render'")));
}

TEST(Load, SaysWhatALaterBuildWillHave) {
  EXPECT_THAT(refusal(load_text(replaced(SMALL_SHOT, "\"micropolar\"", "\"plate\""))),
              HasSubstr("material.skin.thickness is missing: a plate that is no sheet"));
  EXPECT_THAT(refusal(load_text(replaced(SMALL_SHOT, "box = { size = [1, 1, 1] }", "region = { box = 1 }"))),
              testing::Not(HasSubstr("shape is missing")))
      << "one cause, one error";
}

TEST(Load, ContactIsThereWhenItsTableIsAndSlidesAsItRestsUnlessToldOtherwise) {
  EXPECT_FALSE(load_text(SMALL_SHOT)->contact.has_value());
  const Result<Shot> shot = load_with("[contact]\nfriction = 0.7\n");
  ASSERT_TRUE(shot) << shot.error().message;
  ASSERT_TRUE(shot->contact.has_value());
  EXPECT_TRUE(*shot->contact->between && *shot->contact->within);
  EXPECT_EQ(*shot->contact->friction.friction, 0.7);
  EXPECT_FALSE(shot->contact->friction.sliding_friction.has_value());
  EXPECT_FALSE(load_with("[contact.pair.a]\nfirst = \"skin\"\nsecond = \"nobody\"\nfriction = 1\n").ok());
}

TEST(Load, StatesUnitsAndTheAdmissibleInterval) {
  EXPECT_EQ(refusal(load_text(replaced(SMALL_SHOT, "5e4", "-5"))),
            "t.toml:12:18: material.skin.youngs_modulus = -5: expected a positive modulus in Pa");
  for (const char* ratio : {"0.5", "0.51", "-1", "-1.0", "7"}) {
    EXPECT_THAT(refusal(load_text(replaced(SMALL_SHOT, "0.4", ratio))),
                AllOf(StartsWith("t.toml:13:17: material.skin.poisson_ratio = "), HasSubstr("in (-1, 0.5)")))
        << ratio;
  }
  EXPECT_TRUE(load_text(replaced(SMALL_SHOT, "0.4", "0.4999")).ok());
  EXPECT_TRUE(load_text(replaced(SMALL_SHOT, "0.4", "-0.999")).ok());
}

TEST(Load, RefusesWhatIsNotFinite) {
  for (const char* number : {"nan", "inf", "-inf", "+nan"}) {
    EXPECT_THAT(refusal(load_text(replaced(SMALL_SHOT, "5e4", number))), HasSubstr("expected a positive modulus"))
        << number;
    EXPECT_THAT(refusal(load_with(fmt::format("[[collider]]\nplane = {{ height = {} }}\n", number))),
                HasSubstr("height"))
        << number;
    EXPECT_THAT(refusal(load_text(replaced(SMALL_SHOT, "[1, 1, 1]", fmt::format("[1, {}, 1]", number)))),
                HasSubstr("t.toml:6:"))
        << number;
  }
}

TEST(Load, SaysWhatTypeItFound) {
  EXPECT_THAT(refusal(load_text(replaced(SMALL_SHOT, "5e4", "\"5e4\""))),
              HasSubstr("= \"5e4\": this is text; expected a positive modulus in Pa, without quotes"));
  EXPECT_THAT(refusal(load_text(replaced(SMALL_SHOT, "5e4", "2020-01-01"))), HasSubstr("a date or time"));
  EXPECT_THAT(refusal(load_text(replaced(SMALL_SHOT, "[1, 1, 1]", "[1, 1]"))),
              HasSubstr("a list of 2; expected a list of 3"));
  EXPECT_THAT(refusal(load_text(replaced(SMALL_SHOT, "[[body]]", "[body]"))),
              HasSubstr("expected tables written [[body]]"));
  EXPECT_THAT(refusal(load_with("[fem]\nkeep = 2.5\n")), HasSubstr("expected an integer in [1, 1000]"));
}

TEST(Load, ReportsAllErrorsInTheOrderOfTheFile) {
  const std::string message = refusal(load_text(R"([shot]
fps = 0
[[body]]
name = "a"
sphere = { radius = -1 }
resolution = 0.1
material = "skni"
[material.skin]
model = "nohookean"
poisson_ratio = 0.3
)"));
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 4) << message;
  std::vector<std::size_t> places;
  for (const char* part : {"t.toml:2:7: shot.fps", "t.toml:5:21: body.a.sphere.radius", "t.toml:7:12: body.a.material",
                           "t.toml:8:1: material.skin.youngs_modulus is missing", "t.toml:9:9: material.skin.model"}) {
    places.push_back(message.find(part));
    EXPECT_NE(places.back(), std::string::npos) << part << " not in\n" << message;
  }
  EXPECT_TRUE(std::is_sorted(places.begin(), places.end())) << message;
}

TEST(Load, StopsReportingAtTheLimit) {
  std::string text = SMALL_SHOT;
  for (int i = 0; i < 30; ++i) {
    text += fmt::format("wrong{} = 1\n", i);
  }
  const std::string message = refusal(load_text(text));
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), MAX_ERRORS);
  EXPECT_THAT(message, HasSubstr("and 10 more errors"));
}

TEST(Load, NamesCannotLeaveTheOutputFolder) {
  for (const char* name : {"..", ".", "../x", "a/b", "", "a b", ".hidden", "-rf", "a\\u0000b", "a\\nb", "\\u00e9"}) {
    EXPECT_FALSE(load_text(replaced(SMALL_SHOT, "\"small\"", fmt::format("\"{}\"", name))).ok()) << name;
    EXPECT_FALSE(load_text(replaced(SMALL_SHOT, "\"block\"", fmt::format("\"{}\"", name))).ok()) << name;
  }
  EXPECT_FALSE(load_with("[render]\nviews = [\"heat.../../x\"]\n").ok());
  EXPECT_FALSE(load_with("[look.\"../x\"]\n").ok());
  EXPECT_TRUE(load_text(replaced(SMALL_SHOT, "\"small\"", "\"sh010_v2.1-a\"")).ok());
}

TEST(Load, RefusesTwoThingsOfOneName) {
  const std::string twice = R"([[collider]]
name = "floor"
plane = {}
[[collider]]
name = "floor"
plane = {}
)";
  EXPECT_THAT(refusal(load_with(twice)), AllOf(StartsWith("t.toml:18:8: collider.floor.name"), HasSubstr("line 14")));
}

TEST(Load, PresetsGiveWayToKeys) {
  const Result<Shot> shot = load_with("[material.f]\npreset = \"felt\"\ndensity = 300\n");
  ASSERT_TRUE(shot.ok()) << shot.error().message;
  const Material& felt = *shot->find_material("f");
  EXPECT_EQ(*felt.density, 300.0);
  EXPECT_EQ(felt.density.source.origin, Origin::file);
  EXPECT_EQ(felt.youngs_modulus.source.origin, Origin::preset);
  EXPECT_EQ(felt.youngs_modulus.source.text(), "preset felt: material.f.youngs_modulus");
  EXPECT_EQ(refusal(load_with("[material.f]\npreset = \"fetl\"\n")).find("missing"), std::string::npos);
  EXPECT_THAT(refusal(load_with("[material.f]\npreset = \"fetl\"\n")), HasSubstr("did you mean 'felt'?"));
}

TEST(Load, MissingFilesAndFoldersHaveTheirOwnErrors) {
  EXPECT_EQ(load_shot("no/such.toml").error().code, ErrorCode::missing_input);
  EXPECT_EQ(load_shot(testing::TempDir()).error().code, ErrorCode::bad_input);
}

TEST(Load, BoundsWhatItReads) {
  EXPECT_THAT(refusal(load_text(std::string(MAX_FILE_BYTES + 1, '#'))), HasSubstr("at most 1048576"));
  EXPECT_THAT(refusal(load_text("a = " + std::string(100'000, '['))),
              HasSubstr("t.toml:1:21: tables, lists or keys nested"));
  EXPECT_THAT(refusal(load_text("a = " + std::string(100'000, '{'))), HasSubstr("nested"));
  std::string dotted = "a";
  for (int i = 0; i < 200'000; ++i) {
    dotted += ".a";
  }
  EXPECT_THAT(refusal(load_text(dotted + " = 1")), HasSubstr("nested"));
  EXPECT_THAT(refusal(load_text("[" + dotted + "]")), HasSubstr("nested"));
  EXPECT_THAT(refusal(load_text("x = \"[[[[[[[[[[[[[[[[[[[[[[\" # [[[[[[[[[[[[[[[[[[[[[\n")), HasSubstr("no such key"))
      << "brackets in strings and comments do not nest";
  std::string many;
  for (int i = 0; i < 5000; ++i) {
    many += fmt::format("key{} = 1\n", i);
  }
  EXPECT_THAT(refusal(load_text(many)), HasSubstr("a table with 5000 keys"));
  std::string bodies;
  for (int i = 0; i < 1500; ++i) {
    bodies += "[[body]]\n";
  }
  EXPECT_THAT(refusal(load_text(bodies)), HasSubstr("1500 of them; at most 1000"));
}

TEST(Load, SaysWhereTomlBreaks) {
  EXPECT_THAT(refusal(load_text("[shot]\nname = \"x\nfps = 3\n")), StartsWith("t.toml:2:"));
  EXPECT_THAT(refusal(load_text("[shot]\nfps = 1\nfps = 2\n")), StartsWith("t.toml:3:"));
  EXPECT_THAT(refusal(load_text("[shot\n")), AllOf(StartsWith("t.toml:1:"), HasSubstr("not TOML")));
}

} // namespace
} // namespace wry::shots
