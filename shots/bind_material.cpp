#include "shots/bind.h"

namespace wry::shots {
namespace {

constexpr std::array AXES{"x", "y", "z"};

Curvature bind_curvature(const Reader& reader) {
  Curvature curvature;
  curvature.model = reader.choice<CurvatureModel>(
      "model", {{"isotropic", CurvatureModel::isotropic}, {"orthotropic", CurvatureModel::orthotropic}});
  curvature.alpha = reader.number("alpha");
  curvature.beta = reader.number("beta");
  curvature.gamma = reader.number("gamma");
  const Reader stiffness = reader.child("stiffness");
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      curvature.stiffness[i][j] = stiffness.number(std::string(AXES[i]) + AXES[j]);
    }
  }
  curvature.basis = reader.columns("basis");
  return curvature;
}

} // namespace

Material bind_material(const Reader& reader, const std::string& name) {
  using M = MaterialModel;
  Material material;
  material.source = reader.source();
  material.name = Located<std::string>(name, reader.source());
  material.preset = reader.optional_text("preset");
  material.model = reader.choice<M>("model", {{"neo-hookean", M::neo_hookean},
                                              {"neo-hookean-eq16", M::neo_hookean_eq16},
                                              {"stvk", M::stvk},
                                              {"corotated", M::corotated},
                                              {"micropolar", M::micropolar},
                                              {"micropolar-det", M::micropolar_det},
                                              {"micropolar-neo-hookean", M::micropolar_neo_hookean},
                                              {"plate", M::plate},

                                              {"mpm", M::mpm}});
  material.density = reader.number("density");
  material.youngs_modulus = reader.number("youngs_modulus");
  material.poisson_ratio = reader.number("poisson_ratio");
  material.couple_modulus_ratio = reader.number("couple_modulus_ratio");
  material.length_scale = reader.number("length_scale");
  material.rotary_inertia = reader.number("rotary_inertia");
  material.thickness = reader.optional_number("thickness");
  material.bending = reader.choice<PlateBending>("bending", {{"h3", PlateBending::h3}, {"curv", PlateBending::curv}});
  material.max_stretch = reader.optional_number("max_stretch");
  material.microrotation = reader.choice<Microrotation>(
      "microrotation",
      {{"auto", Microrotation::automatic}, {"solved", Microrotation::solved}, {"condensed", Microrotation::condensed}});
  material.matter = bind_matter(reader);
  material.mass_damping = reader.number("mass_damping");
  material.stiffness_damping = reader.number("stiffness_damping");
  const Reader vary = reader.child("vary");
  const auto factor = [&](const char* key, std::optional<Located<Expression>>& out) {
    const Located<Expression> entry = vary.expression(key);
    if (vary.has(key)) {
      out = entry;
    }
  };
  factor("density", material.vary.density);
  factor("youngs_modulus", material.vary.youngs_modulus);
  factor("couple_modulus_ratio", material.vary.couple_modulus_ratio);
  factor("length_scale", material.vary.length_scale);
  material.curvature = bind_curvature(reader.child("curvature"));
  const Reader rest = reader.child("rest_curvature");
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const std::string key = std::string(AXES[i]) + AXES[j];
      const Located<Expression> entry = rest.expression(key);
      if (rest.has(key)) {
        material.rest_curvature[i][j] = entry;
      }
    }
  }
  return material;
}

} // namespace wry::shots
