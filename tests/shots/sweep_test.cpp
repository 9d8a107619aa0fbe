#include "shots/sweep.h"

#include <cmath>
#include <set>

#include "tests/shots/shots_support.h"

namespace wry::shots {
namespace {

using testing::HasSubstr;

Result<std::vector<Wedge>> expand(const std::string& sweep) {
  const Result<ShotDocument> document = read_document_text(SMALL_SHOT + sweep, "t.toml", ".");
  EXPECT_TRUE(document.ok()) << document.error().message;
  return expand_sweep(*document);
}

Result<Shot> shot_of(const std::string& sweep, const Wedge& wedge) {
  return load_with(sweep, wedge.overrides);
}

TEST(Sweep, WithoutASweepThereAreNoWedges) {
  EXPECT_TRUE(expand("")->empty());
}

TEST(Sweep, ListsMultiplyOutWithTheLastRunningFastest) {
  const std::string sweep = R"([sweep]
"material.skin.length_scale" = [0, 0.1, 1]
material.skin.model = ["micropolar", "micropolar-det"]
)";
  const auto wedges = expand(sweep);
  ASSERT_TRUE(wedges.ok()) << wedges.error().message;
  ASSERT_EQ(wedges->size(), 6u);
  EXPECT_EQ((*wedges)[3].name, "length_scale=0.1, model=micropolar-det");
  EXPECT_EQ((*wedges)[3].index, 3);
  std::set<std::string> hashes;
  for (const Wedge& wedge : *wedges) {
    hashes.insert(wedge.hash);
    EXPECT_TRUE(shot_of(sweep, wedge).ok());
  }
  EXPECT_EQ(hashes.size(), 6u);
  const Result<Shot> shot = shot_of(sweep, (*wedges)[3]);
  EXPECT_EQ(*shot->materials[0].length_scale, 0.1);
  EXPECT_EQ(*shot->materials[0].model, MaterialModel::micropolar_det);
}

TEST(Sweep, TheSameParametersKeepTheirHash) {
  const auto small = expand("[sweep]\n\"shot.fps\" = [24, 25]\n");
  const auto large = expand("[sweep]\n\"shot.fps\" = [12, 24, 25, 30]\n");
  EXPECT_EQ((*small)[1].hash, (*large)[2].hash);
  EXPECT_NE((*small)[0].hash, (*large)[0].hash);
  EXPECT_EQ((*small)[1].id(), fmt::format("001-{}", (*small)[1].hash));
  EXPECT_EQ((*small)[1].hash.size(), 8u);
}

TEST(Sweep, RangesAreLinearOrLogarithmic) {
  const auto linear = expand("[sweep]\n\"shot.fps\" = { from = 10, to = 20, count = 3 }\n");
  ASSERT_TRUE(linear.ok()) << linear.error().message;
  EXPECT_EQ((*linear)[1].overrides[0].value, "15.0");
  const auto logarithmic =
      expand("[sweep]\n\"material.skin.youngs_modulus\" = { from = 1e3, to = 1e5, count = 3, scale = \"log\" }\n");
  ASSERT_TRUE(logarithmic.ok()) << logarithmic.error().message;
  EXPECT_NEAR(std::stod((*logarithmic)[1].overrides[0].value), 1e4, 1e-8);
  EXPECT_EQ(std::stod((*logarithmic)[2].overrides[0].value), 1e5);
}

TEST(Sweep, ZippedListsRunTogether) {
  const auto wedges = expand("[sweep]\nmode = \"zip\"\n\"shot.fps\" = [24, 25]\n\"render.samples\" = [1, 2]\n");
  ASSERT_EQ(wedges->size(), 2u);
  EXPECT_EQ((*wedges)[1].overrides[0].value, "25");
  EXPECT_EQ((*wedges)[1].overrides[1].value, "2");
  const auto unequal = expand("[sweep]\nmode = \"zip\"\n\"shot.fps\" = [24, 25]\n\"render.samples\" = [1]\n");
  EXPECT_THAT(unequal.error().message, HasSubstr("zipped lists are equally long"));
}

TEST(Sweep, ALatinHypercubeHasOneSampleInEachStratum) {
  const std::string sweep = R"([sweep]
mode = "latin-hypercube"
samples = 50
"shot.fps" = { from = 10, to = 60 }
"material.skin.youngs_modulus" = { from = 1, to = 1e5, scale = "log" }
)";
  const auto wedges = expand(sweep);
  ASSERT_TRUE(wedges.ok()) << wedges.error().message;
  ASSERT_EQ(wedges->size(), 50u);
  std::set<int> linear, logarithmic;
  for (const Wedge& wedge : *wedges) {
    linear.insert(static_cast<int>(std::floor(std::stod(wedge.overrides[0].value) - 10.0)));
    logarithmic.insert(static_cast<int>(std::floor(std::log10(std::stod(wedge.overrides[1].value)) * 10.0)));
  }
  EXPECT_EQ(linear.size(), 50u);
  EXPECT_EQ(logarithmic.size(), 50u);
  const auto again = expand(sweep);
  EXPECT_EQ((*wedges)[17].overrides[0].value, (*again)[17].overrides[0].value) << "drawn from the shot's seed";
}

TEST(Sweep, NamedCasesSetTheirKeys) {
  const std::string sweep = R"([[sweep.case]]
name = "soft"
set = { "material.skin.model" = "neo-hookean", "body.block.resolution" = 0.2 }
[[sweep.case]]
name = "stiff"
set = { material.skin.youngs_modulus = 2e5 }
)";
  const auto wedges = expand(sweep);
  ASSERT_TRUE(wedges.ok()) << wedges.error().message;
  ASSERT_EQ(wedges->size(), 2u);
  EXPECT_EQ((*wedges)[0].name, "soft");
  const Result<Shot> soft = shot_of(sweep, (*wedges)[0]);
  ASSERT_TRUE(soft.ok()) << soft.error().message;
  EXPECT_EQ(*soft->materials[0].model, MaterialModel::neo_hookean);
  EXPECT_EQ(soft->materials[0].model.source.line, 16) << "the line of the case";
  EXPECT_EQ(**soft->bodies[0].resolution, 0.2);
  EXPECT_EQ(**soft->sweep_case, "soft");
  EXPECT_EQ(*shot_of(sweep, (*wedges)[1])->materials[0].youngs_modulus, 2e5);
  EXPECT_FALSE(load_with(sweep)->sweep_case);
  EXPECT_EQ(*load_with(sweep, {{"material.skin.model", "stvk", {}}, {"case", "soft", {}}})->materials[0].model,
            MaterialModel::stvk)
      << "--set wins over the case, whatever the order";
  EXPECT_THAT(refusal(load_with(sweep, {{"case", "stif", {}}})), HasSubstr("did you mean 'stiff'?"));
}

TEST(Sweep, CasesTimesLists) {
  const auto wedges = expand(R"([sweep]
"body.block.resolution" = [0.1, 0.2]
[[sweep.case]]
name = "a"
set = { "shot.fps" = 12 }
[[sweep.case]]
name = "b"
set = { "shot.fps" = 13 }
)");
  ASSERT_EQ(wedges->size(), 4u);
  EXPECT_EQ((*wedges)[2].name, "b, resolution=0.1");
}

TEST(Sweep, ErrorsHaveTheirLine) {
  EXPECT_THAT(expand("[sweep]\n\"shot.fps\" = []\n").error().message, HasSubstr("t.toml:15:14: sweep.\"shot.fps\""));
  EXPECT_THAT(expand("[sweep]\n\"shot.fps\" = 3\n").error().message, HasSubstr("expected a list"));
  EXPECT_THAT(expand("[sweep]\n\"body.blok.resolution\" = [1]\n").error().message, HasSubstr("did you mean 'block'?"));
  EXPECT_THAT(expand("[sweep]\n\"shot.fps\" = { from = 1, to = 2 }\n").error().message,
              HasSubstr("from, to and count"));
  EXPECT_THAT(expand("[sweep]\n\"shot.fps\" = { from = 0, to = 2, count = 3, scale = \"log\" }\n").error().message,
              HasSubstr("above 0"));
  EXPECT_THAT(expand("[sweep]\nmode = \"latin-hypercube\"\n\"shot.fps\" = [1]\n").error().message,
              HasSubstr("number of wedges"));
  EXPECT_THAT(expand("[sweep]\n\"material.skin.lenght_scale\" = [1]\n").error().message,
              HasSubstr("there is no key 'material.skin.lenght_scale' in a shot; did you mean 'length_scale'?"));
  EXPECT_TRUE(expand("[sweep]\n\"shot.gravity.1\" = [-1, -2]\n").ok()) << "an entry of a list";
  EXPECT_TRUE(expand("[sweep]\nmaterial.skin.curvature.stiffness.yy = [1, 2]\n").ok()) << "a table not yet there";
  EXPECT_THAT(expand("[sweep]\n\"sweep.mode\" = [1]\n").error().message, HasSubstr("cannot be swept"));
  EXPECT_THAT(expand("[[sweep.case]]\nname = \"a\"\n").error().message, HasSubstr("expected name"));
  EXPECT_THAT(expand("[[sweep.case]]\nname = \"a\"\nset = {}\nsets = {}\n").error().message,
              HasSubstr("sweep case; did you mean 'set'?"));
  EXPECT_THAT(refusal(load_with("[sweep]\n\"shot.fps\" = []\n")), HasSubstr("sweep")) << "found without expanding too";
}

TEST(Sweep, IsBounded) {
  std::string sweep = "[sweep]\n";
  for (const char* key : {"shot.fps", "shot.seed", "render.samples", "render.exposure"}) {
    sweep += fmt::format("\"{}\" = {{ from = 1, to = 2, count = 9999 }}\n", key);
  }
  EXPECT_THAT(expand(sweep).error().message, HasSubstr("more than 10000 wedges"));
  EXPECT_FALSE(expand("[sweep]\n\"shot.fps\" = { from = 1, to = 2, count = 1000000000 }\n").ok());
}

} // namespace
} // namespace wry::shots
