#include "sim/mpm/matter/make_matter.h"

#include <algorithm>
#include <numbers>

#include <Eigen/Dense>

namespace wry::mpm {

namespace {

constexpr double DEGREES = 180.0 / std::numbers::pi;

OrthotropicElasticity elasticity_of(const Material& material) {
  OrthotropicElasticity e;
  e.youngs_modulus = {material.youngs_modulus[0], material.youngs_modulus[1], material.youngs_modulus[2]};
  e.nu_yz = material.poisson_ratio.yz;
  e.nu_xz = material.poisson_ratio.xz;
  e.nu_xy = material.poisson_ratio.xy;
  if (material.shear_modulus)
    e.shear_modulus = Vec3(material.shear_modulus->yz, material.shear_modulus->zx, material.shear_modulus->xy);
  return e;
}

Error refusal(const StiffnessCheck& check) {
  std::string message;
  for (const StiffnessViolation& v : check.violations) {
    message += fmt::format("{}the elasticity is not positive definite: expected {}, but {:.6g} against {:.6g}",
                           message.empty() ? "" : "; ", v.inequality, v.left, v.right);
    if (!v.admissible.empty())
      message += v.ratio.empty() ? fmt::format("; admissible alone: {}", v.admissible)
                                 : fmt::format("; poisson_ratio.{} may lie in {}", v.ratio, v.admissible);
  }
  return make_error(ErrorCode::bad_input, "{}", message);
}

StrainMeasure measure_of(const Material& material) {
  if (material.measure != StrainMeasure::automatic)
    return material.measure;
  return material.elasticity == Elasticity::linear ? StrainMeasure::biot : StrainMeasure::hencky;
}

bool is_isotropic(const Material& material) {
  const auto same = [](const PerAxis& values) { return values[0] == values[1] && values[1] == values[2]; };
  const auto& nu = material.poisson_ratio;
  return same(material.youngs_modulus) && nu.yz == nu.xz && nu.xz == nu.xy && !material.shear_modulus &&
         material.plastic_scale == PerAxis{1, 1, 1} && !material.plastic_map && !material.stress_map &&
         !material.strain_map && !material.reorientation;
}

YieldRule rule_of(const Material& material) {
  YieldRule rule;
  rule.law = material.plasticity;
  rule.snow = {material.critical_compression, material.critical_stretch, material.snow_hardening};
  rule.friction = {material.friction_angle * DEGREES, 0.0, 0.0, 0.0};
  if (const auto& h = material.friction_hardening)
    rule.friction = {(*h)[0] * DEGREES, (*h)[1] * DEGREES, (*h)[2], (*h)[3] * DEGREES};
  rule.flow = material.flow;
  rule.volume_correction = material.volume_correction;
  rule.shear_limit = material.shear_limit;
  return rule;
}

Mat6 stress_map_of(const Material& material) {
  if (material.stress_map)
    return *material.stress_map;
  if (material.plastic_map)
    return congruence_map(*material.plastic_map);
  return stress_map(Vec3(material.plastic_scale[0], material.plastic_scale[1], material.plastic_scale[2]));
}

/// The material as it is when all grains point along z.
Material aligned(const Material& material) {
  Material result = material;
  const OrientedParameters p = interpolate_parameters(orientation_limits(*material.reorientation), Vec3::UnitZ());
  const OrthotropicElasticity e = p.elasticity();
  result.youngs_modulus = {e.youngs_modulus[0], e.youngs_modulus[1], e.youngs_modulus[2]};
  result.poisson_ratio = {e.nu_yz, e.nu_xz, e.nu_xy};
  result.plastic_scale = {p.plastic_scale[0], p.plastic_scale[1], p.plastic_scale[2]};
  return result;
}

void warn_of_hydrostatic_flow(const Matter& matter, const Mat6& map, std::vector<std::string>& warnings) {
  if (matter.plasticity.law != Plasticity::drucker_prager)
    return;
  const FrictionHardening& friction = matter.plasticity.friction;
  const double least = least_friction_angle(map), start = friction.h0 - friction.h3;
  if (least >= start)
    warnings.push_back(fmt::format("plastic_scale flows under pressure alone: it needs a friction_angle above {:.3g} "
                                   "degrees and has {:.3g}; raise friction_angle or bring the scales closer together",
                                   least, start));
}

Status make_anisotropic(const Material& material, Matter& matter, std::vector<std::string>& warnings) {
  const Mat6 map = stress_map_of(material);
  if (Status status = check_stress_map(map); !status)
    return make_error(ErrorCode::bad_input, "stress map: {}", status.error().message);
  if (material.fictitious) {
    matter.fictitious = lame_moduli(material.fictitious->youngs_modulus, material.fictitious->poisson_ratio);
  } else {
    const Result<LameModuli> fit = fit_isotropic(matter.stiffness, map);
    if (!fit)
      return fit.error();
    matter.fictitious = *fit;
  }
  matter.maps = make_maps(matter.stiffness, matter.fictitious, map);
  if (material.strain_map) {
    const Result<double> asymmetry = check_strain_map(*material.strain_map, matter.fictitious, map);
    if (!asymmetry)
      return make_error(ErrorCode::bad_input, "strain map: {}", asymmetry.error().message);
    if (*asymmetry > 1e-6)
      warnings.push_back(
          fmt::format("the elastic tangent of the strain map has a relative asymmetry of {:.3g}: elastic "
                      "work is not conserved",
                      *asymmetry));
    matter.maps.strain = *material.strain_map;
    matter.maps.strain_inverse = material.strain_map->inverse();
    matter.stiffness = matter.maps.stress_inverse * isotropic_stiffness(matter.fictitious) * matter.maps.strain;
  }
  warn_of_hydrostatic_flow(matter, map, warnings);
  return {};
}

} // namespace

OrientationLimits orientation_limits(const Reorientation& grains) {
  const auto axis = [](const AxisLimits& l) {
    return AxisParameters{l.youngs_modulus, l.poisson_ratio, l.plastic_scale};
  };
  return {.isotropic = axis(grains.isotropic),
          .parallel = axis(grains.parallel),
          .perpendicular = axis(grains.perpendicular)};
}

Result<Matter> make_matter(const Material& given, std::vector<std::string>* warnings) {
  std::vector<std::string> ignored;
  std::vector<std::string>& notes = warnings != nullptr ? *warnings : ignored;
  if (given.reorientation) {
    const StiffnessCheck check = check_limits(orientation_limits(*given.reorientation));
    if (!check.positive_definite())
      return refusal(check);
  }
  const Material material = given.reorientation ? aligned(given) : given;
  const OrthotropicElasticity elasticity = elasticity_of(material);
  const StiffnessCheck check = check_orthotropic(elasticity);
  if (!check.positive_definite())
    return refusal(check);
  Matter matter;
  matter.elasticity = material.elasticity;
  matter.measure = measure_of(material);
  if ((matter.elasticity == Elasticity::linear && matter.measure == StrainMeasure::hencky) ||
      (matter.elasticity == Elasticity::hencky && matter.measure == StrainMeasure::biot))
    return make_error(ErrorCode::bad_input, "{} has one strain measure; only fixed-corotated has a choice",
                      elasticity_name(matter.elasticity));
  matter.plasticity = rule_of(material);
  matter.frame = material.frame;
  if (matter.frame == FrameMode::automatic)
    matter.frame = material.plasticity == Plasticity::none ? FrameMode::polar : FrameMode::shape;
  matter.isotropic = is_isotropic(material);
  matter.stiffness = orthotropic_stiffness(elasticity);
  if (matter.isotropic) {
    matter.fictitious = lame_moduli(material.youngs_modulus[0], material.poisson_ratio.xy);
    matter.stiffness = isotropic_stiffness(matter.fictitious);
    return matter;
  }
  if (Status status = make_anisotropic(material, matter, notes); !status)
    return status.error();
  return matter;
}

double stiffest_modulus(const Material& material, const Matter& matter) {
  if (!material.reorientation)
    return stiffest_wave_modulus(matter.stiffness);
  const OrientationLimits limits = orientation_limits(*material.reorientation);
  double stiffest = 0.0;
  for (const Vec3& eigenvalues :
       {Vec3(1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0), Vec3(0, 0, 1), Vec3(0, 1.0 / 3.0, 2.0 / 3.0), Vec3(0, 0.5, 0.5)}) {
    const Mat6 C = orthotropic_stiffness(interpolate_parameters(limits, eigenvalues).elasticity());
    stiffest = std::max(stiffest, stiffest_wave_modulus(C));
  }
  return stiffest;
}

} // namespace wry::mpm
