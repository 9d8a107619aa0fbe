#include <numbers>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "sim/mpm/material.h"
#include "sim/mpm/matter/make_matter.h"

namespace wry::mpm {

namespace {

constexpr double DEGREES = 180.0 / std::numbers::pi;

void fill(double (&to)[36], const Mat6& from) {
  for (int i = 0; i < 36; ++i)
    to[i] = from(i / 6, i % 6);
}

/// Whether a map keeps normal strains among themselves and each shear to itself.
bool is_block(const Mat6& map) {
  Mat6 rest = map;
  rest.topLeftCorner<3, 3>().setZero();
  rest.diagonal().tail<3>().setZero();
  return rest.cwiseAbs().maxCoeff() <= 1e-14 * map.cwiseAbs().maxCoeff();
}

void fill_limits(const Reorientation& grains, MaterialConstants<double>& constants) {
  const AxisLimits* const limits[3] = {&grains.isotropic, &grains.parallel, &grains.perpendicular};
  for (int i = 0; i < 3; ++i) {
    constants.axis_modulus[i] = limits[i]->youngs_modulus;
    constants.axis_ratio[i] = limits[i]->poisson_ratio;
    constants.axis_scale[i] = limits[i]->plastic_scale;
  }
  constants.jeffery = jeffery_shape(grains.length_over_width);
}

MaterialConstants<double> constants_of(const Material& material, const Matter& matter) {
  const YieldRule& rule = matter.plasticity;
  MaterialConstants<double> constants;
  constants.elasticity_law = matter.elasticity;
  constants.plasticity = rule.law;
  constants.measure = matter.measure;
  constants.flow = rule.flow;
  constants.frame = matter.frame;
  constants.hardens = rule.law == Plasticity::drucker_prager && !rule.friction.is_constant();
  constants.corrects_volume = rule.law == Plasticity::drucker_prager && rule.volume_correction;
  constants.uses_maps = needs_maps(matter) || (material.reorientation && rule.law != Plasticity::none);
  constants.block_maps = is_block(matter.stiffness) && is_block(matter.maps.strain) &&
                         is_block(matter.maps.strain_inverse) && is_block(matter.maps.stress_inverse);
  constants.reorients = material.reorientation.has_value();
  constants.lambda = matter.fictitious.lambda;
  constants.mu = matter.fictitious.mu;
  fill(constants.elasticity, matter.stiffness);
  fill(constants.strain_map, matter.maps.strain);
  fill(constants.strain_map_inverse, matter.maps.strain_inverse);
  fill(constants.stress_map_inverse, matter.maps.stress_inverse);
  const FrictionHardening& friction = rule.friction;
  constants.friction_angle[0] = friction.h0 / DEGREES;
  constants.friction_angle[1] = friction.h1 / DEGREES;
  constants.friction_angle[2] = friction.h2;
  constants.friction_angle[3] = friction.h3 / DEGREES;
  constants.friction_alpha = drucker_prager_alpha(friction.h0 - friction.h3);
  constants.critical_compression = rule.snow.compression;
  constants.critical_stretch = rule.snow.stretch;
  constants.snow_hardening = rule.snow.hardening;
  constants.shear_limit = rule.shear_limit;
  if (material.reorientation)
    fill_limits(*material.reorientation, constants);
  return constants;
}

std::vector<Channel> channels_of(const Material& material, const Matter& matter,
                                 const MaterialConstants<double>& constants) {
  std::vector<Channel> channels;
  const auto want = [&channels](Channel channel, bool wanted) {
    if (wanted)
      channels.push_back(channel);
  };
  want(Channel::hardening, constants.hardens);
  want(Channel::plastic_volume, constants.plasticity == Plasticity::snow);
  want(Channel::volume_correction, constants.corrects_volume);
  want(Channel::frame, !matter.isotropic);
  want(Channel::second_moment, constants.reorients);
  want(Channel::stiffness_scale, material.stiffness_varies);
  want(Channel::strength_scale, material.strength_varies && constants.plasticity != Plasticity::none);
  return channels;
}

std::string plasticity_words(const YieldRule& rule) {
  switch (rule.law) {
  case Plasticity::none:
    return "no plasticity";
  case Plasticity::snow:
    return fmt::format("snow {:g} / {:g}, hardening {:g}", rule.snow.compression, rule.snow.stretch,
                       rule.snow.hardening);
  case Plasticity::drucker_prager:
    return fmt::format(
        "Drucker-Prager phi {:g}{}{}{}", rule.friction.h0, rule.friction.is_constant() ? "" : " with hardening",
        rule.volume_correction ? ", volume correction" : "", rule.flow == Flow::isochoric ? ", isochoric flow" : "");
  case Plasticity::shear:
    return fmt::format("shear limit {:g}", rule.shear_limit);
  }
  return "?";
}

std::string fictitious_words(const LameModuli& moduli) {
  return fmt::format("fictitious E {:.4g} Pa, nu {:.4g}",
                     moduli.mu * (3.0 * moduli.lambda + 2.0 * moduli.mu) / (moduli.lambda + moduli.mu),
                     moduli.lambda / (2.0 * (moduli.lambda + moduli.mu)));
}

void describe(const Matter& matter, CompiledMaterial& compiled) {
  const auto& constants = compiled.constants;
  std::string axes = "isotropic: no maps, no frames";
  if (constants.reorients)
    axes = fmt::format("grains that reorient: maps of each particle, {}", fictitious_words(matter.fictitious));
  else if (!matter.isotropic && constants.uses_maps)
    axes = fmt::format("{}: one set of maps, {}", constants.block_maps ? "orthotropic" : "general anisotropy",
                       fictitious_words(matter.fictitious));
  else if (!matter.isotropic)
    axes = "anisotropic: stiffness alone";
  compiled.runs =
      fmt::format("{}, {}, {}", elasticity_name(matter.elasticity), plasticity_words(matter.plasticity), axes);
  using Part = LeftOut::Part;
  if (matter.isotropic)
    compiled.left_out.push_back({Part::frames_and_maps, "material frames and maps", "it is isotropic"});
  else if (!constants.uses_maps)
    compiled.left_out.push_back({Part::maps, "maps", "the law is linear in strain and there is no plasticity"});
  if (!matter.isotropic && !constants.reorients)
    compiled.left_out.push_back({Part::second_moment, "second moments of grains", "no reorient"});
  if (constants.uses_maps && !constants.reorients)
    compiled.left_out.push_back({Part::maps_of_each_particle, "maps of each particle", "one set serves all"});
  if (constants.plasticity == Plasticity::drucker_prager && !constants.hardens)
    compiled.left_out.push_back({Part::hardening, "hardening", "friction is constant"});
}

} // namespace

Result<CompiledMaterial> compile_material(const Material& material) {
  CompiledMaterial compiled;
  Result<Matter> matter = make_matter(material, &compiled.warnings);
  if (!matter)
    return matter.error();
  compiled.constants = constants_of(material, *matter);
  compiled.channels = channels_of(material, *matter, compiled.constants);
  compiled.sound_speed = std::sqrt(stiffest_modulus(material, *matter) / material.density);
  describe(*matter, compiled);
  return compiled;
}

template <class Scalar> MaterialConstants<Scalar> constants_in(const MaterialConstants<double>& from) {
  MaterialConstants<Scalar> to;
  const auto copy = [](auto& target, const auto& source) {
    for (std::size_t i = 0; i < std::size(source); ++i)
      target[i] = static_cast<Scalar>(source[i]);
  };
  to.elasticity_law = from.elasticity_law;
  to.plasticity = from.plasticity;
  to.measure = from.measure;
  to.flow = from.flow;
  to.frame = from.frame;
  to.hardens = from.hardens;
  to.corrects_volume = from.corrects_volume;
  to.uses_maps = from.uses_maps;
  to.block_maps = from.block_maps;
  to.reorients = from.reorients;
  to.lambda = static_cast<Scalar>(from.lambda);
  to.mu = static_cast<Scalar>(from.mu);
  copy(to.elasticity, from.elasticity);
  copy(to.strain_map, from.strain_map);
  copy(to.strain_map_inverse, from.strain_map_inverse);
  copy(to.stress_map_inverse, from.stress_map_inverse);
  copy(to.friction_angle, from.friction_angle);
  to.friction_alpha = static_cast<Scalar>(from.friction_alpha);
  to.critical_compression = static_cast<Scalar>(from.critical_compression);
  to.critical_stretch = static_cast<Scalar>(from.critical_stretch);
  to.snow_hardening = static_cast<Scalar>(from.snow_hardening);
  to.shear_limit = static_cast<Scalar>(from.shear_limit);
  copy(to.axis_modulus, from.axis_modulus);
  copy(to.axis_ratio, from.axis_ratio);
  copy(to.axis_scale, from.axis_scale);
  to.jeffery = static_cast<Scalar>(from.jeffery);
  return to;
}
template MaterialConstants<float> constants_in<float>(const MaterialConstants<double>&);
template MaterialConstants<double> constants_in<double>(const MaterialConstants<double>&);

} // namespace wry::mpm
