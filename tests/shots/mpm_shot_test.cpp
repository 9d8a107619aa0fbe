#include "shots/load.h"

#include "tests/shots/shots_support.h"

namespace wry::shots {
namespace {

using testing::HasSubstr;

const std::string PILE = R"([[body]]
name = "pile"
region = { box = { min = [0, 0, 0], max = [1, 1, 1] } }
material = "sand"
[material.sand]
model = "mpm"
youngs_modulus = 1e5
poisson_ratio = 0.3
)";

TEST(MpmShot, OneNumberStandsForAllAxes) {
  const Result<Shot> shot = load_text(PILE);
  ASSERT_TRUE(shot.ok()) << shot.error().message;
  const Matter& matter = shot->find_material("sand")->matter;
  for (const Located<double>& value : matter.youngs_modulus.values)
    EXPECT_EQ(*value, 1e5);
  for (const Located<double>& value : matter.plastic_scale.values)
    EXPECT_EQ(*value, 1.0);
  EXPECT_TRUE(shot->is_particles(shot->bodies[0]));
}

TEST(MpmShot, TablesNameTheirAxes) {
  const Result<Shot> shot =
      load_text(replaced(PILE, "youngs_modulus = 1e5", "youngs_modulus = { z = 3, x = 1, y = 2 }"));
  ASSERT_TRUE(shot.ok()) << shot.error().message;
  const PerAxis& moduli = shot->find_material("sand")->matter.youngs_modulus;
  EXPECT_EQ(*moduli.values[0], 1.0);
  EXPECT_EQ(*moduli.values[1], 2.0);
  EXPECT_EQ(*moduli.values[2], 3.0);
  EXPECT_THAT(refusal(load_text(replaced(PILE, "youngs_modulus = 1e5", "youngs_modulus = { x = 1, y = 2 }"))),
              HasSubstr("material.sand.youngs_modulus.z is missing"));
}

TEST(MpmShot, AxesAreReachedFromTheCommandLine) {
  const std::string text = PILE + "plastic_scale = { x = 1, y = 1, z = 1 }\n";
  const Result<Shot> shot = load_text(text, {*parse_override("material.sand.plastic_scale.z=0.5")});
  ASSERT_TRUE(shot.ok()) << shot.error().message;
  EXPECT_EQ(*shot->find_material("sand")->matter.plastic_scale.values[2], 0.5);
}

TEST(MpmShot, KeysOfTheOtherMethodAreRefusedWithTheirLine) {
  EXPECT_THAT(refusal(load_text(replaced(PILE, "material = ", "resolution = 0.1\nmaterial = "))),
              HasSubstr("t.toml:4:14: body.pile.resolution: only solids are cut into tets"));
  const std::string solid = replaced(PILE, "\"mpm\"", "\"neo-hookean\"");
  EXPECT_THAT(refusal(load_text(solid)), HasSubstr("body.pile.region: sand is not of model = \"mpm\""));
  EXPECT_THAT(refusal(load_text(solid + "plasticity = \"snow\"\n")),
              HasSubstr("material.sand.plasticity: only model = \"mpm\" reads this key"));
}

TEST(MpmShot, EmptyRegionsAreRefused) {
  EXPECT_THAT(refusal(load_text(replaced(PILE, "[1, 1, 1]", "[1, 0, 1]"))), HasSubstr("it is empty"));
}

TEST(MpmShot, OnlyOnePlasticMapCanStand) {
  EXPECT_THAT(refusal(load_text(PILE + "plastic_scale = 2\nplastic_map = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n")),
              HasSubstr("plastic map is given already by plastic_scale"));
}

} // namespace
} // namespace wry::shots
