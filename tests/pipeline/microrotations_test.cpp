#include "pipeline/plan/microrotations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/shots/shots_support.h"

namespace wry::pipeline {
namespace {

using ::testing::HasSubstr;

/// A bar whose microrotations may be condensed, beside another, and what a test adds.
MicrorotationChoice choice_with(const std::string& more, const std::string& microrotation = "auto") {
  const Result<shots::Shot> shot = shots::load_text(R"([shot]
name = "small"

[[body]]
name = "bar"
rod = { length = 1, width = 0.1 }
resolution = 0.1
material = "skin"

[[body]]
name = "other"
rod = { length = 1, width = 0.1 }
resolution = 0.1
translate = [0, 1, 0]
material = "skin"

[material.skin]
model = "micropolar"
youngs_modulus = 5e4
poisson_ratio = 0
length_scale = 0
microrotation = ")" + microrotation + "\"\n" + more);
  if (!shot) {
    ADD_FAILURE() << shot.error().message;
    return {};
  }
  return choose_microrotations(*shot, shot->bodies[0], shot->materials[0]);
}

std::string drive(const std::string& what) {
  return "[[drive]]\nname = \"end\"\nbody = \"bar\"\nwhere = { expression = \"u > 0.99\" }\n"
         "keys = [{ time = 0 }, { time = 1, axis = \"x\", degrees = 90 }]\ndrive = [" +
         what + "]\n";
}

std::string measure(const std::string& kind, const std::string& body = "bar") {
  return "[[measure]]\nname = \"m\"\nkind = \"" + kind + "\"\nbody = \"" + body + "\"\n";
}

TEST(Microrotations, AreCondensedWhereNothingReadsThem) {
  EXPECT_TRUE(choice_with("").condensed);
  EXPECT_TRUE(choice_with(drive("\"positions\"")).condensed);
  EXPECT_TRUE(choice_with(measure("height")).condensed);
  EXPECT_TRUE(choice_with(measure("rotation_distance", "other")).condensed) << "another body's";
  EXPECT_TRUE(choice_with("[[load]]\nname = \"push\"\nbody = \"bar\"\nforce = { y = \"1\" }\n").condensed);
  EXPECT_TRUE(choice_with("[render]\nviews = [\"beauty\", \"heat.speed\"]\n").condensed);
}

TEST(Microrotations, AreSolvedForWhereTheyAreSeenMeasuredDrivenOrLoaded) {
  struct Case {
    std::string text, why;
  };
  for (const Case& with : {
           Case{drive("\"positions\", \"microrotations\""), "the drive end"},
           Case{drive("\"microrotations\""), "the drive end"},
           Case{measure("rotation_distance"), "the measure m"},
           Case{measure("element_twist_max"), "the measure m"},
           Case{measure("curvature_error"), "the measure m"},
           Case{measure("rotation_interpolation_error"), "the measure m"},
           Case{"[[load]]\nname = \"turn\"\nbody = \"bar\"\ntorque = { y = \"1\" }\n", "the load turn"},
           Case{"[[fixed]]\nname = \"still\"\nbody = \"bar\"\nwhere = { expression = \"u < 0.01\" }\n"
                "hold = [\"microrotations\"]\n",
                "the hold still"},
           Case{"[render]\nviews = [\"directors\"]\n", "the view directors"},
           Case{"[render]\nviews = [\"heat.microrotation\"]\n", "the view heat.microrotation"},
       }) {
    const MicrorotationChoice choice = choice_with(with.text);
    EXPECT_FALSE(choice.condensed) << with.text;
    EXPECT_THAT(choice.why, HasSubstr(with.why));
  }
}

TEST(Microrotations, CondensedByOrderOfTheShotWarnsOfWhoReadsThem) {
  const MicrorotationChoice choice = choice_with(measure("rotation_distance"), "condensed");
  EXPECT_TRUE(choice.condensed);
  EXPECT_THAT(choice.warning, HasSubstr("the measure m reads them"));
  EXPECT_EQ(choice_with("", "condensed").warning, "");
}

} // namespace
} // namespace wry::pipeline
