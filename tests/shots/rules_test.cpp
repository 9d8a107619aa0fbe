#include "tests/shots/shots_support.h"

namespace wry::shots {
namespace {

using testing::HasSubstr;

std::string body_refusal(const std::string& lines) {
  return refusal(load_text(replaced(SMALL_SHOT, "box = { size = [1, 1, 1] }\nresolution = 0.1\n", lines)));
}

std::string material_refusal(const std::string& lines) {
  return refusal(load_with(lines));
}

TEST(Rules, ABodyHasOneShapeAndAResolution) {
  EXPECT_THAT(body_refusal("resolution = 0.1\n"), HasSubstr("body.block: the shape is missing"));
  EXPECT_THAT(body_refusal("sphere = { radius = 1 }\n"), HasSubstr("body.block.resolution is missing"));
  EXPECT_THAT(body_refusal("box = { size = [1, 1, 1] }\n"), HasSubstr("or cells = [nx, ny, nz]"));
  EXPECT_THAT(body_refusal("sphere = { radius = 1 }\ncells = [1, 2, 3]\n"),
              HasSubstr("only a box, rod, sheet or cylinder"));
  EXPECT_THAT(body_refusal("box = { size = [1, 1, 1] }\ncells = [9999, 9999, 9999]\n"), HasSubstr("at most 2e+07"));
  EXPECT_THAT(body_refusal("sphere = { radius = 1 }\nresolution = 0.1\nunits = \"cm\"\n"),
              HasSubstr("only mesh files"));
  EXPECT_THAT(body_refusal("torus = { radius = 1, tube_radius = 1 }\nresolution = 0.1\n"), HasSubstr("no hole"));
  EXPECT_EQ(body_refusal("mesh = \"beam.msh\"\n"), "accepted") << "a tet mesh has its own edges";
  EXPECT_THAT(body_refusal("mesh = \"beam.MSH\"\nshell = { thickness = 1 }\n"), HasSubstr("cannot be hollowed"));
  EXPECT_THAT(body_refusal("mesh = \"beam.obj\"\nscale = 2\nsize = { max = 1 }\nresolution = 1\n"),
              HasSubstr("keep one of the two"));
  EXPECT_THAT(body_refusal("mesh = \"beam.obj\"\nsize = {}\nresolution = 1\n"),
              HasSubstr("one of height, width, depth, max"));
}

TEST(Rules, ALookIsOneOfTheShotOrBuiltIn) {
  EXPECT_EQ(refusal(load_with("", {{"body.block.look", "metal", {}}})), "accepted");
  EXPECT_THAT(refusal(load_with("", {{"body.block.look", "metl", {}}})),
              HasSubstr("no [look.metl]; did you mean 'metal'?"));
  EXPECT_THAT(refusal(load_with("[look.shiny]\n", {{"body.block.look", "shimy", {}}})), HasSubstr("'shiny'"));
}

TEST(Rules, SomethingHoldsTheMicrorotations) {
  EXPECT_THAT(material_refusal("couple_modulus_ratio = 0\n"), HasSubstr("nothing holds the microrotations"));
  EXPECT_EQ(material_refusal("couple_modulus_ratio = 0\nrotary_inertia = 1\n"), "accepted");
  EXPECT_EQ(material_refusal("couple_modulus_ratio = 0\nlength_scale = 1\n"), "accepted");
  EXPECT_EQ(refusal(load_text(replaced(SMALL_SHOT, "\"micropolar\"", "\"stvk\"") + "couple_modulus_ratio = 0\n")),
            "accepted");
}

TEST(Rules, CurvatureEnergiesHaveALeastValue) {
  EXPECT_THAT(material_refusal("curvature = { alpha = 1, gamma = -0.4 }\n"),
              HasSubstr("gamma >= -alpha/3 = -0.333333"));
  EXPECT_EQ(material_refusal("curvature = { alpha = 1, gamma = -0.3 }\n"), "accepted");
  EXPECT_THAT(material_refusal("curvature = { model = \"orthotropic\", stiffness = { yx = -1 } }\n"),
              HasSubstr("curvature.stiffness.yx = -1: expected a stiffness >= 0"));
  EXPECT_THAT(material_refusal("curvature = { model = \"orthotropic\" }\n"), HasSubstr("with an entry above 0"));
  EXPECT_THAT(material_refusal("curvature = { stiffness = { yx = 1 } }\n"), HasSubstr("write curvature.model"));
  EXPECT_THAT(material_refusal("curvature = { model = \"orthotropic\", alpha = 2, stiffness = { yx = 1 } }\n"),
              HasSubstr("a weight of the isotropic model"));
}

TEST(Rules, ABasisIsOrthonormalAndRightHanded) {
  const auto with_basis = [](const std::string& basis) {
    return material_refusal("curvature = { model = \"orthotropic\", stiffness = { yy = 1 }, basis = " + basis + " }\n");
  };
  EXPECT_EQ(with_basis("[[0, 1, 0], [0, 0, 1], [1, 0, 0]]"), "accepted");
  EXPECT_EQ(with_basis("[[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]]"), "accepted");
  EXPECT_THAT(with_basis("[[2, 0, 0], [0, 1, 0], [0, 0, 1]]"), HasSubstr("axis x has length 2"));
  EXPECT_THAT(with_basis("[[1, 0, 0], [0.6, 0.8, 0], [0, 0, 1]]"), HasSubstr("axes x and y have the dot product 0.6"));
  EXPECT_THAT(with_basis("[[0, 1, 0], [1, 0, 0], [0, 0, 1]]"), HasSubstr("left-handed"));
  EXPECT_THAT(with_basis("[[1, 0], [0, 1, 0], [0, 0, 1]]"), HasSubstr("a list of 2"));
}

TEST(Rules, RegionsAreNotEmpty) {
  EXPECT_THAT(refusal(load_with("[[fixed]]\nwhere = { box = { min = [0, 1, 0], max = [1, 0, 1] } }\n")),
              HasSubstr("along y the box ends at 0 before it begins at 1"));
  EXPECT_THAT(
      refusal(load_with("[[fixed]]\nwhere = { cylinder = { from = [0, 1, 0], to = [0, 1, 0], radius = 1 } }\n")),
      HasSubstr("needs a length"));
  EXPECT_THAT(refusal(load_with("[[fixed]]\nwhere = {}\n")), HasSubstr("the region is missing"));
  EXPECT_THAT(refusal(load_with("[[fixed]]\nwhere = { expression = \"\" }\n")), HasSubstr("printable"));
  EXPECT_THAT(refusal(load_with("[[fixed]]\nwhere = { expression = \"1\" }\nhold = []\n")),
              HasSubstr("list of some of"));
}

TEST(Rules, MeasuresAndExpectationsAreWhole) {
  EXPECT_THAT(refusal(load_with("[[measure]]\nname = \"m\"\nkind = \"extent\"\n")),
              HasSubstr("measure.m.axis is missing"));
  EXPECT_THAT(refusal(load_with("[[measure]]\nname = \"m\"\nkind = \"height\"\naxis = \"x\"\n")),
              HasSubstr("remove it"));
  const std::string measure = "[[measure]]\nname = \"m\"\nkind = \"height\"\n[expect.e]\n";
  EXPECT_THAT(refusal(load_with(measure + "measure = \"m\"\n")), HasSubstr("give min, max or both"));
  EXPECT_THAT(refusal(load_with(measure + "measure = \"m\"\nmin = 2\nmax = 1\n")), HasSubstr("at least min = 2"));
  const Result<Shot> late = load_with(measure + "measure = \"m\"\nmin = 2\nframe = 9999\n");
  EXPECT_THAT(refusal(late), HasSubstr("expect.e.frame = 9999: the shot has frames 1 to "));
  EXPECT_THAT(refusal(late), testing::MatchesRegex("^[^:]+:[0-9]+:[0-9]+: (.|\n)*"));
  EXPECT_THAT(refusal(load_with(measure + "measure = \"m\"\nmin = 2\nframe = 0\n")), HasSubstr("expected one of them"));
  EXPECT_EQ(refusal(load_with(measure + "measure = \"m\"\nmin = 2\nframe = 2\n", {{"shot.frames", "1", {}}})),
            "accepted")
      << "cut at the command line: the run says that it is not judged";
  EXPECT_THAT(refusal(load_with(measure + "measure = \"n\"\nmin = 2\n")),
              HasSubstr("there is no [[measure]] with this name"));
  EXPECT_THAT(refusal(load_with(measure + "measure = \"m\"\nmin = 2\nratio_to = \"x\"\n")),
              HasSubstr("[[sweep.case]]"));
}

TEST(Rules, AMultitudeOfBodiesHasToBeNamed) {
  const std::string second = "[[body]]\nname = \"b\"\nsphere = { radius = 1 }\nresolution = 1\nmaterial = \"skin\"\n";
  EXPECT_THAT(refusal(load_with(second + "[[fixed]]\nwhere = { expression = \"1\" }\n")),
              HasSubstr("fixed.fixed1.body is missing: the shot has 2 bodies"));
  EXPECT_THAT(refusal(load_text("[shot]\n")), HasSubstr("at least one [[body]]"));
}

TEST(Rules, CamerasAndStepsAgreeWithThemselves) {
  EXPECT_THAT(refusal(load_with("[render]\ncamera = { position = [1, 1, 1], target = [1, 1, 1] }\n")),
              HasSubstr("stands where"));
  EXPECT_THAT(refusal(load_with("[render]\ncamera = { position = [1, 1, 1], azimuth_deg = 3 }\n")),
              HasSubstr("keep one"));
  EXPECT_THAT(refusal(load_with("[fem]\ntime_step = 1e-3\nmin_time_step = 1e-2\n")),
              HasSubstr("at most time_step = 0.001 s"));
  EXPECT_THAT(refusal(load_with("[render.heat.speed]\nmin = 1\nmax = 1\n")), HasSubstr("more than min = 1"));
  EXPECT_THAT(refusal(load_with("[render]\nviews = [\"beauty\", \"beauty\"]\n")), HasSubstr("listed twice"));
  EXPECT_THAT(refusal(load_with("[render]\nviews = [\"bauty\"]\n")), HasSubstr("did you mean 'beauty'?"));
  EXPECT_THAT(refusal(load_with("[[collider]]\nplane = { normal = [0, 0, 0] }\n")), HasSubstr("no length"));
}

} // namespace
} // namespace wry::shots
