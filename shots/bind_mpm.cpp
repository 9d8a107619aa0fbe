#include "shots/bind.h"

namespace wry::shots {
namespace {

PerAxis bind_per_axis(const Reader& reader, const std::string& key, std::array<const char*, 3> names) {
  PerAxis found;
  const Reader table = reader.child(key);
  found.is_table = table.has(names[0]);
  for (std::size_t i = 0; i < 3; ++i) {
    found.values[i] = found.is_table ? table.number(names[i]) : reader.number(key);
  }
  return found;
}

template <std::size_t N>
std::optional<Located<std::array<double, N>>> bind_list(const Reader& reader, const std::string& key) {
  const Located<std::vector<double>> list = reader.numbers(key);
  if (!reader.has(key)) {
    return std::nullopt;
  }
  std::array<double, N> values{};
  for (std::size_t i = 0; i < N && i < list->size(); ++i) {
    values[i] = (*list)[i];
  }
  return Located<std::array<double, N>>(values, list.source);
}

std::optional<Located<Expression>> bind_optional_expression(const Reader& reader, const std::string& key) {
  const Located<Expression> expression = reader.expression(key);
  return reader.has(key) ? std::optional(expression) : std::nullopt;
}

void bind_maps(const Reader& reader, Matter& matter) {
  matter.plastic_scale = bind_per_axis(reader, "plastic_scale", {"x", "y", "z"});
  if (!reader.has("plastic_scale")) { // plastic_map or stress_map takes its place
    for (Located<double>& value : matter.plastic_scale.values) {
      value.value = 1.0;
    }
  }
  const Located<Mat3> map = reader.columns("plastic_map");
  if (reader.has("plastic_map")) {
    matter.plastic_map = Located<Mat3>(map->transpose(), map.source); // rows are given
  }
  matter.stress_map = bind_list<36>(reader, "stress_map");
  matter.strain_map = bind_list<36>(reader, "strain_map");
  const Reader fictitious = reader.child("fictitious");
  Matter::Fictitious isotropic{fictitious.source(), fictitious.number("youngs_modulus"),
                               fictitious.number("poisson_ratio")};
  if (reader.has("fictitious")) {
    matter.fictitious = isotropic;
  }
}

void bind_yield(const Reader& reader, Matter& matter) {
  matter.friction_angle = reader.number("friction_angle");
  matter.friction_hardening = bind_list<4>(reader, "friction_hardening");
  matter.flow = reader.choice<PlasticFlow>(
      "flow", {{"fictitious", PlasticFlow::fictitious}, {"isochoric", PlasticFlow::isochoric}});
  matter.volume_correction = reader.boolean("volume_correction");
  matter.critical_compression = reader.number("critical_compression");
  matter.critical_stretch = reader.number("critical_stretch");
  matter.snow_hardening = reader.number("snow_hardening");
  matter.shear_limit = reader.number("shear_limit");
}

std::variant<BoxSpace, SphereSpace, CylinderSpace> bind_space(const Reader& region) {
  if (region.has("sphere")) {
    const Reader sphere = region.child("sphere");
    return SphereSpace{sphere.vector("centre"), sphere.number("radius")};
  }
  if (region.has("cylinder")) {
    const Reader cylinder = region.child("cylinder");
    return CylinderSpace{cylinder.vector("from"), cylinder.vector("to"), cylinder.number("radius")};
  }
  const Reader box = region.child("box");
  return BoxSpace{box.vector("min"), box.vector("max")};
}

std::optional<ReorientLimit> bind_limit(const Reader& reorient, const char* key) {
  const Reader reader = reorient.child(key);
  const ReorientLimit limit{reader.number("youngs_modulus"), reader.number("poisson_ratio"),
                            reader.number("plastic_scale")};
  return reorient.has(key) ? std::optional(limit) : std::nullopt;
}

SubParticleOptions bind_grains(const Reader& reader, const std::string& directory) {
  using F = GrainForm;
  SubParticleOptions grains;
  grains.source = reader.source();
  grains.per_particle = reader.integer("per_particle");
  grains.shape = reader.choice<F>("shape", {{"rod", F::rod},
                                            {"straw", F::straw},
                                            {"card", F::card},
                                            {"coin", F::coin},
                                            {"brick", F::brick},
                                            {"sphere", F::sphere}});
  if (reader.has("mesh")) {
    grains.mesh = bind_path(reader, "mesh", directory);
  }
  grains.mesh_along = reader.choice<std::size_t>("mesh_along", {{"x", 0}, {"y", 1}, {"z", 2}});
  grains.size = reader.optional_vector("size");
  grains.size_variation = reader.number("size_variation");
  grains.spread_deg = reader.number("spread_deg");
  grains.seed = reader.integer("seed");
  grains.escape_density = reader.number("escape_density");
  grains.capture_density = reader.number("capture_density");
  grains.travel = reader.number("travel");
  return grains;
}

Fibre bind_fibre(const Reader& reader) {
  Fibre fibre;
  fibre.source = reader.source();
  fibre.direction = reader.optional_vector("direction");
  fibre.tilt_deg = reader.optional_number("tilt_deg");
  fibre.azimuth_deg = reader.number("azimuth_deg");
  fibre.second_moment = reader.optional_vector("second_moment");
  fibre.across = reader.optional_vector("across");
  if (reader.has("expression")) {
    const Reader components = reader.child("expression");
    fibre.expression.emplace();
    for (std::size_t i = 0; i < 3; ++i) {
      (*fibre.expression)[i] = bind_optional_expression(components, std::string(1, "xyz"[i]));
    }
  }
  return fibre;
}

} // namespace

Matter bind_matter(const Reader& reader) {
  Matter matter;
  matter.elasticity = reader.choice<Elasticity>("elasticity", {{"linear", Elasticity::linear},
                                                               {"hencky", Elasticity::hencky},
                                                               {"fixed-corotated", Elasticity::fixed_corotated}});
  matter.plasticity = reader.choice<Plasticity>("plasticity", {{"none", Plasticity::none},
                                                               {"snow", Plasticity::snow},
                                                               {"drucker-prager", Plasticity::drucker_prager},
                                                               {"shear", Plasticity::shear}});
  matter.youngs_modulus = bind_per_axis(reader, "youngs_modulus", {"x", "y", "z"});
  matter.poisson_ratio = bind_per_axis(reader, "poisson_ratio", {"yz", "xz", "xy"});
  const Reader shear = reader.child("shear_modulus");
  const std::array<Located<double>, 3> moduli{shear.number("yz"), shear.number("zx"), shear.number("xy")};
  if (reader.has("shear_modulus")) {
    matter.shear_modulus = moduli;
  }
  bind_maps(reader, matter);
  matter.frame = reader.choice<MaterialFrame>("frame", {{"auto", MaterialFrame::automatic},
                                                        {"polar", MaterialFrame::polar},
                                                        {"shape", MaterialFrame::shape},
                                                        {"fixed", MaterialFrame::fixed}});
  matter.measure = reader.choice<StrainMeasure>(
      "strain_measure",
      {{"auto", StrainMeasure::automatic}, {"hencky", StrainMeasure::hencky}, {"biot", StrainMeasure::biot}});
  bind_yield(reader, matter);
  matter.stiffness_scale = bind_optional_expression(reader, "stiffness_scale");
  matter.strength_scale = bind_optional_expression(reader, "strength_scale");
  const Reader reorient = reader.child("reorient");
  const Reorient grains{reorient.source(), reorient.number("length_over_width"), bind_limit(reorient, "isotropic"),
                        bind_limit(reorient, "parallel"), bind_limit(reorient, "perpendicular")};
  if (reader.has("reorient")) {
    matter.reorient = grains;
  }
  for (const Field& field : mpm_material_fields()) {
    if (reader.differs(field.key, field.value)) {
      matter.given.push_back(reader.source_of(field.key));
    }
  }
  return matter;
}

ParticleBody bind_particles(const Reader& reader, const std::string& directory) {
  ParticleBody particles;
  if (reader.has("region")) {
    const Reader region = reader.child("region");
    particles.region =
        ParticleRegion{region.source(), bind_space(region), bind_optional_expression(region, "expression")};
  }
  particles.per_cell = reader.number("particles_per_cell");
  if (reader.has("fibre")) {
    particles.fibre = bind_fibre(reader.child("fibre"));
  }
  if (reader.has("source")) {
    const Reader source = reader.child("source");
    particles.repeat = ParticleSource{source.source(), source.number("every"), source.number("until")};
  }
  if (reader.has("sub_particles")) {
    particles.grains = bind_grains(reader.child("sub_particles"), directory);
  }
  return particles;
}

MpmOptions bind_mpm(const Reader& reader) {
  MpmOptions mpm;
  mpm.source = reader.source();
  mpm.cell_size = reader.optional_number("cell_size");
  mpm.transfer =
      reader.choice<GridTransfer>("transfer", {{"gradient", GridTransfer::gradient}, {"mls", GridTransfer::mls}});
  mpm.precision =
      reader.choice<NumberPrecision>("precision", {{"f32", NumberPrecision::f32}, {"f64", NumberPrecision::f64}});
  mpm.sampling = reader.choice<ParticleSampling>(
      "sampling", {{"lattice", ParticleSampling::lattice}, {"jittered", ParticleSampling::jittered}});
  mpm.time_step = reader.optional_number("time_step");
  mpm.courant = reader.number("courant");
  mpm.max_deformation = reader.number("max_deformation");
  mpm.keep_fields = reader.boolean("keep_fields");
  if (reader.has("semi_implicit")) {
    const Reader semi = reader.child("semi_implicit");
    mpm.semi_implicit = SemiImplicitOptions{semi.number("courant"), semi.number("implicitness"), semi.number("damping"),
                                            semi.number("tolerance")};
  }
  return mpm;
}

} // namespace wry::shots
