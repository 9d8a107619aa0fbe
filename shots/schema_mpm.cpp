#include "shots/schema.h"

namespace wry::shots {
namespace {

Interval place() {
  return between(-1e9, 1e9);
}

Field table(std::string key, std::vector<Field> fields, std::string doc) {
  Section section;
  section.doc = doc;
  section.fields = std::move(fields);
  return nested(std::move(key), Kind::table, std::move(section), std::move(doc));
}

Field region_field() {
  Section section;
  section.doc = "Where particles of the material point method stand at the start, in the shot's world.";
  section.fields = {
      table("box",
            {numbers("min", 3, "m", place(), "The least corner.").required(),
             numbers("max", 3, "m", place(), "The greatest corner.").required()},
            "A box."),
      table("sphere",
            {numbers("centre", 3, "m", place(), "The middle.").required(),
             number("radius", "m", positive(1e9), "Radius.").called("radius").required()},
            "A ball."),
      table("cylinder",
            {numbers("from", 3, "m", place(), "One end of the axis.").required(),
             numbers("to", 3, "m", place(), "The other end.").required(),
             number("radius", "m", positive(1e9), "Radius.").called("radius").required()},
            "A cylinder."),
      plain("expression", Kind::expression, "Of the region, only where this formula of X, Y, Z is not 0.")
          .default_is("everywhere"),
  };
  section.one_of = {{{{"box"}, {"sphere"}, {"cylinder"}}, true, "region"}};
  return nested("region", Kind::table, section, section.doc);
}

Field fibre_field() {
  Section section;
  section.doc = "Where the material's local z, the fibre or a card's normal, points at the start.";
  const Field component =
      plain("", Kind::expression,
            "A component of the direction: a number or a formula of X, Y, Z and attributes of the body's mesh.")
          .default_is("0");
  std::vector<Field> components;
  for (const char* axis : {"x", "y", "z"}) {
    Field field = component;
    field.key = axis;
    components.push_back(field);
  }
  section.fields = {
      plain("direction", Kind::direction, "The direction.").default_is("z"),
      number("tilt_deg", "degrees", between(-360, 360), "The angle from up, in place of direction.")
          .called("angle")
          .default_is("none"),
      number("azimuth_deg", "degrees", between(-360, 360),
             "With tilt_deg: the angle about up, from x (y when up is x) counter-clockwise.")
          .called("angle")
          .default_is("0"),
      table("expression", components, "The direction from formulas, not yet of length 1, in place of direction."),
      numbers(
          "second_moment", 3, "", between(0.0, 1.0),
          "How the grains' directions are spread at the start: the shares along the local x, y, z, which sum to 1. It "
          "matters to what is drawn, and to materials that reorient.")
          .default_is("all along z: [0, 0, 1]"),
      plain("across", Kind::direction, "Local x is this, made perpendicular to the fibre.")
          .default_is("the axis that is farthest from the fibre"),
  };
  section.one_of = {{{{"direction"}, {"tilt_deg", "azimuth_deg"}, {"expression"}}, false, "fibre"}};
  return nested("fibre", Kind::table, section, section.doc).default_is("along z");
}

Field source_field() {
  return table("source",
               {number("every", "s", positive(1e9), "The body's particles are added again each time this has passed.")
                    .called("time")
                    .required(),
                number("until", "s", at_least_zero(1e9), "No addition after this time.").called("time").required()},
               "Makes the region a source: what flows out of it is followed by more.");
}

Field semi_implicit_field() {
  return table(
             "semi_implicit",
             {number("courant", "", strictly_between(0.0, 1e3), "How many cells the fastest wave may cross in a step.")
                  .called("number")
                  .standard(4.0),
              number("implicitness", "", between(0.25, 1.0),
                     "The share b of the stiffness in (M + b dt^2 K)(v' - v) = dt f - d b dt^2 K v.")
                  .called("number")
                  .standard(1.0),
              number("damping", "", between(0.0, 1.0),
                     "The share d. 1: backward Euler, which damps what is too fast for the step away and the rest a "
                     "little; 0: slow waves keep their energy, and fast ones swing more slowly.")
                  .called("number")
                  .standard(1.0),
              number("tolerance", "", strictly_between(0.0, 1.0),
                     "The residual that conjugate gradients leave, over the first one.")
                  .called("number")
                  .standard(0.01)},
             "Steps that stiff fibres do not bound: a linear solve on the grid in each.")
      .default_is("none: explicit steps");
}

} // namespace

std::vector<Field> mpm_body_fields() {
  return {
      region_field(),
      number("particles_per_cell", "", positive(1e5), "Particles of the material point method per cell of its grid.")
          .called("number")
          .standard(8.0),
      fibre_field(),
      source_field(),
      sub_particles_field(),
  };
}

std::vector<Field> mpm_material_fields() {
  const Interval modulus = positive();
  return {
      reorient_field(),
      choice("elasticity",
             {{"linear", "linear in the corotated strain V - I", ""},
              {"hencky", "linear in the logarithmic strain", ""},
              {"fixed-corotated", "with a volume term that grows with compression", ""}},
             "Of the material point method: the elastic law.")
          .standard("hencky"),
      choice("plasticity",
             {{"none", "elastic", ""},
              {"snow", "stretches are clipped, and what is compacted hardens", ""},
              {"drucker-prager", "sand: friction, no tension", ""},
              {"shear", "the difference of principal strains is limited", ""}},
             "Of the material point method: how it yields.")
          .standard("none"),
      table("shear_modulus",
            {number("yz", "Pa", modulus, "In the plane y z.").called("modulus").required(),
             number("zx", "Pa", modulus, "In the plane z x.").called("modulus").required(),
             number("xy", "Pa", modulus, "In the plane x y.").called("modulus").required()},
            "Shear moduli of an orthotropic material.")
          .default_is("from the moduli and ratios (Li and Barbic)"),
      number("plastic_scale", "", positive(1e3),
             "How strong the material yields along its axes compared with the fictitious isotropic one: A^sigma is "
             "diag(x, y, z) on both sides.")
          .called("factor")
          .standard(1.0)
          .or_per({"x", "y", "z"}, positive(1e3)),
      plain("plastic_map", Kind::matrix, "A full matrix D in place of plastic_scale: A^sigma S = D S D^T.")
          .default_is("from plastic_scale"),
      numbers("stress_map", 36, "", between(-1e6, 1e6),
              "A^sigma itself in Mandel's notation (xx yy zz yz zx xy), row after row, in place of plastic_scale.")
          .default_is("from plastic_scale"),
      numbers("strain_map", 36, "", between(-1e9, 1e9), "A^E in the same notation.")
          .default_is("from A^sigma and the elasticities"),
      table("fictitious",
            {number("youngs_modulus", "Pa", modulus, "Its modulus.").called("modulus").required(),
             number("poisson_ratio", "", strictly_between(-1.0, 0.5), "Its ratio.").called("ratio").required()},
            "The fictitious isotropic material in which an anisotropic one yields.")
          .default_is("the nearest isotropic one"),
      choice("frame",
             {{"auto", "polar when it does not yield, else shape", ""},
              {"polar", "the rotation of the elastic deformation", ""},
              {"shape", "turned along with the particle's neighbourhood", ""},
              {"fixed", "not at all, however the matter turns: to see what frames do", ""}},
             "How the material's axes turn.")
          .standard("auto"),
      choice("strain_measure",
             {{"auto", "of the elastic law", ""},
              {"hencky", "the logarithm of the stretch", ""},
              {"biot", "the stretch minus 1", ""}},
             "The strain of the fixed-corotated law.")
          .standard("auto"),
      number("friction_angle", "degrees", between(0.0, 89.0), "Of drucker-prager.").called("angle").standard(35.0),
      numbers("friction_hardening", 4, "", any_number(),
              "phi(q) = h0 + (h1 q - h3) exp(-h2 q) in degrees, in place of friction_angle: [h0, h1, h2, h3].")
          .default_is("none"),
      choice("flow",
             {{"fictitious", "keeps the volume of the fictitious material", ""}, {"isochoric", "keeps the volume", ""}},
             "The direction in which drucker-prager flows.")
          .standard("fictitious"),
      boolean("volume_correction", "Of drucker-prager: volume gained while it was apart is taken back.")
          .standard(false),
      number("critical_compression", "", strictly_between(0.0, 1.0), "Of snow: theta_c.")
          .called("strain")
          .standard(0.025),
      number("critical_stretch", "", strictly_between(0.0, 10.0), "Of snow: theta_s.")
          .called("strain")
          .standard(0.0075),
      number("snow_hardening", "", at_least_zero(1e3), "Of snow: xi.").called("factor").standard(10.0),
      number("shear_limit", "", positive(10.0), "Of shear: the greatest difference of principal strains, k.")
          .called("strain")
          .standard(0.0025),
      plain("stiffness_scale", Kind::expression,
            "A factor on all moduli of the material point method: a number or a formula of X, Y, Z and attributes of "
            "the body's mesh.")
          .default_is("1"),
      plain("strength_scale", Kind::expression,
            "A factor on the yield limit: a number or a formula of X, Y, Z and attributes of the body's mesh.")
          .default_is("1"),
  };
}

Section mpm_section() {
  Section section;
  section.doc = "How the material point method runs.";
  section.fields = {
      number("cell_size", "m", positive(1e6), "Edge of a cell of the grid.")
          .called("length")
          .or_word("auto", "a sixteenth of the least extent of a region"),
      choice("transfer",
             {{"gradient", "forces and deformation by the gradient of the weights: second order", ""},
              {"mls", "moving least squares: a quarter faster, first order", ""}},
             "How grid and particles talk.")
          .standard("gradient"),
      choice("precision", {{"f32", "single", ""}, {"f64", "double", ""}}, "Of the numbers.").standard("f32"),
      choice("sampling",
             {{"lattice", "regular", ""}, {"jittered", "at random in the cells of a lattice, from shot.seed", ""}},
             "How particles stand at the start.")
          .standard("jittered"),
      number("time_step", "s", positive(10.0), "The step; where it is unstable it is cut, and said.")
          .called("time")
          .or_word("auto", "the longest stable step, from the stiffest direction, the speed and the gradient"),
      number("courant", "", strictly_between(0.0, 2.0),
             "How much of a cell the fastest wave may cross in a step; it blows up somewhere above 0.8.")
          .called("number")
          .standard(0.4),
      number("max_deformation", "", strictly_between(0.0, 1.0), "How much a particle may deform in a step.")
          .called("number")
          .standard(0.3),
      semi_implicit_field(),
      boolean("keep_fields",
              "Keeps, beside the frames, the grid that carries grains at each of their updates, so that sub_particles "
              "of another number, seed, shape or size are made again without simulating.")
          .standard(false),
  };
  return section;
}

} // namespace wry::shots
