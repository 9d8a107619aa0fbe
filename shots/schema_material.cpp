#include "shots/presets.h"
#include "shots/schema.h"

namespace wry::shots {
namespace {

std::vector<Field> tensor_fields(const Field& like) {
  std::vector<Field> fields;
  for (const char* axis : {"x", "y", "z"}) {
    for (const char* direction : {"x", "y", "z"}) {
      Field field = like;
      field.key = std::string(axis) + direction;
      fields.push_back(field);
    }
  }
  return fields;
}

Field curvature_field() {
  Section stiffness;
  stiffness.doc = "C_ij: resistance to rotating about axis i while moving along j; what is not listed is 0.";
  stiffness.fields = tensor_fields(number("", "", at_least_zero(), "C_ij.")
                                       .called("stiffness")
                                       .standard(0.0)
                                       .advice("a negative stiffness has no least energy"));
  Section curvature;
  curvature.doc = "The energy of curvature, scaled by mu L_c^2; it acts when length_scale > 0.";
  curvature.fields = {
      choice("model",
             {{"isotropic", "mu L_c^2/2 (alpha |sym|^2 + beta |skew|^2 + gamma tr^2)", ""},
              {"orthotropic", "mu L_c^2 sum C_ij Gamma_ij^2 in the material's axes", ""}},
             "How curvature is resisted.")
          .standard("isotropic"),
      number("alpha", "", at_least_zero(), "Weight of the symmetric part.").standard(1.0),
      number("beta", "", at_least_zero(), "Weight of the skew part.").standard(1.0),
      number("gamma", "", any_number(), "Weight of the trace, the sum of torsions; alpha + 3 gamma >= 0.")
          .standard(1.0),
      nested("stiffness", Kind::table, stiffness, stiffness.doc),
      plain("basis", Kind::matrix, "The material's axes x, y, z, a list each; orthonormal and right-handed.")
          .standard(Value(Array{number_list({1, 0, 0}), number_list({0, 1, 0}), number_list({0, 0, 1})})),
  };
  return nested("curvature", Kind::table, curvature, curvature.doc);
}

Field vary_field() {
  Section section;
  section.doc =
      "Factors on the material's own values, as formulas of X, Y, Z, u, v and mesh attributes; a vertex colour "
      "is colour_x, colour_y, colour_z.";
  for (const char* key : {"density", "youngs_modulus", "couple_modulus_ratio", "length_scale"}) {
    Field entry = plain(key, Kind::expression, "Factor on it; above 0.").default_is("1");
    entry.range = at_least_zero();
    section.fields.push_back(entry);
  }
  return nested("vary", Kind::table, section, section.doc);
}

Field rest_curvature_field() {
  Section section;
  section.doc = "The curvature that costs nothing, about axis i while moving along j [1/m]: a number, or a formula of "
                "t, X, Y, Z, a body's own u, v and mesh attributes. What is not listed is 0.";
  Field entry = plain("", Kind::expression, "Gamma0_ij.").default_is("0");
  entry.unit = "1/m";
  entry.range = between(-1e9, 1e9);
  section.fields = tensor_fields(entry);
  return nested("rest_curvature", Kind::table, section, section.doc);
}

Field model_field() {
  return choice("model",
                {{"neo-hookean", "mu/2 (I_C - 3) - mu ln J + lambda/2 ln^2 J", ""},
                 {"neo-hookean-eq16", "eq 16 of the micropolar paper without its couple modulus", ""},
                 {"stvk", "St. Venant-Kirchhoff; weak under compression", ""},
                 {"corotated", "mu |F - R|^2 + lambda/2 tr(R^T F - I)^2", ""},
                 {"micropolar", "physically linear, eq 11", ""},
                 {"micropolar-det", "eq 11 with the volume term of det F", ""},
                 {"micropolar-neo-hookean", "eq 16", ""},
                 {"plate", "micropolar plates: triangles with a thickness and a director", ""},
                 {"mpm", "the material point method: sand, snow, straw, wood, piles of grains", ""}},
                "The strain energy; micropolar models carry a rotation per node.")
      .required();
}

} // namespace

Section material_section() {
  std::vector<Choice> presets;
  for (const PresetInfo& preset : list_presets()) {
    presets.push_back({preset.name, preset.description, ""});
  }
  Section section;
  section.doc = "How matter resists; the model decides which solver a body needs.";
  section.fields = {
      choice("preset", presets, "Values to start from; keys that are given win."),
      model_field(),
      number("density", "kg/m^3", positive(1e9), "Mass per volume at rest.").called("density").standard(1000.0),
      number("youngs_modulus", "Pa", positive(), "Stiffness against stretch.")
          .called("modulus")
          .required()
          .or_per({"x", "y", "z"}, positive()),
      number("poisson_ratio", "", strictly_between(-1.0, 0.5), "How much it thins when stretched.")
          .called("ratio")
          .required()
          .or_per({"yz", "xz", "xy"}, between(-10.0, 10.0))
          .advice("at 0.5 the bulk modulus is infinite and at -1 the shear modulus; use 0.49 for rubber-like matter"),
      number("couple_modulus_ratio", "", at_least_zero(), "mu_c / mu: how firmly microrotations follow the matter.")
          .called("ratio")
          .standard(1.0),
      number("length_scale", "m", at_least_zero(1e9),
             "L_c: below this size bending and torsion feel stiffer; 0: no curvature energy.")
          .called("length")
          .standard(0.0),
      number("rotary_inertia", "kg/m", at_least_zero(), "j0: inertia of the microrotations.")
          .called("inertia")
          .standard(0.0),
      number("thickness", "m", positive(1e9), "Of a plate.").called("thickness").default_is("that of the body's sheet"),
      choice(
          "bending",
          {{"h3", "h^3/12 (mu |sym K|^2 + mu_c |skew K|^2 + lambda' tr(K)^2): its thickness", ""},
           {"curv", "h mu L_c^2/2 (alpha |sym K|^2 + beta |skew K|^2 + gamma tr(K)^2): the energy of curvature", ""}},
          "What resists the bending of a plate; K is the curvature of its director.")
          .standard("h3"),
      number("max_stretch", "", between(1.0, 1e6),
             "Of a plate: principal stretches beyond are resisted steeply, 1 % beyond like a strain of one.")
          .called("stretch")
          .default_is("no limit"),
      choice("microrotation",
             {{"auto", "condensed where it is exact and nothing reads them, else solved", ""},
              {"solved", "three unknowns per node", ""},
              {"condensed", "minimised away in each element; only of micropolar without energy of curvature", ""}},
             "What becomes of the microrotations.")
          .standard("auto"),
      number("mass_damping", "1/s", at_least_zero(), "Force against the momentum of the matter: slows all motion.")
          .called("damping")
          .standard(0.0),
      number("stiffness_damping", "s", at_least_zero(),
             "Force against the rate of elastic forces: slows vibration, the faster the more.")
          .called("damping")
          .standard(0.0),
      vary_field(),
      curvature_field(),
      rest_curvature_field(),
  };
  for (Field& field : mpm_material_fields()) {
    section.fields.push_back(std::move(field));
  }
  section.one_of = {{{{"plastic_scale"}, {"plastic_map"}, {"stress_map"}}, false, "plastic map"}};
  return section;
}

} // namespace wry::shots
