#include <cmath>
#include <numbers>

#include "pipeline/plan/compile_mpm.h"

namespace wry::pipeline {

namespace {

constexpr double RADIANS = std::numbers::pi / 180.0;

mpm::Elasticity elasticity(shots::Elasticity law) {
  switch (law) {
  case shots::Elasticity::linear:
    return mpm::Elasticity::linear;
  case shots::Elasticity::hencky:
    return mpm::Elasticity::hencky;
  case shots::Elasticity::fixed_corotated:
    return mpm::Elasticity::fixed_corotated;
  }
  return mpm::Elasticity::hencky;
}

mpm::Plasticity plasticity(shots::Plasticity law) {
  switch (law) {
  case shots::Plasticity::none:
    return mpm::Plasticity::none;
  case shots::Plasticity::snow:
    return mpm::Plasticity::snow;
  case shots::Plasticity::drucker_prager:
    return mpm::Plasticity::drucker_prager;
  case shots::Plasticity::shear:
    return mpm::Plasticity::shear;
  }
  return mpm::Plasticity::none;
}

mpm::FrameMode frame_mode(shots::MaterialFrame frame) {
  switch (frame) {
  case shots::MaterialFrame::automatic:
    return mpm::FrameMode::automatic;
  case shots::MaterialFrame::polar:
    return mpm::FrameMode::polar;
  case shots::MaterialFrame::shape:
    return mpm::FrameMode::shape;
  case shots::MaterialFrame::fixed:
    return mpm::FrameMode::fixed;
  }
  return mpm::FrameMode::automatic;
}

mpm::StrainMeasure strain_measure(shots::StrainMeasure measure) {
  switch (measure) {
  case shots::StrainMeasure::automatic:
    return mpm::StrainMeasure::automatic;
  case shots::StrainMeasure::hencky:
    return mpm::StrainMeasure::hencky;
  case shots::StrainMeasure::biot:
    return mpm::StrainMeasure::biot;
  }
  return mpm::StrainMeasure::automatic;
}

mpm::PerAxis per_axis(const shots::PerAxis& values) {
  return {*values.values[0], *values.values[1], *values.values[2]};
}

mpm::Mandel mandel(const std::array<double, 36>& rows) {
  return Eigen::Map<const mpm::Mandel>(rows.data());
}

/// An axis of the material as a limit: its modulus, the ratio of the plane normal to it, its scale.
mpm::AxisLimits axis_of_material(const mpm::Material& material, std::size_t axis) {
  const mpm::PerAxis& E = material.youngs_modulus;
  const double nu[3] = {material.poisson_ratio.yz, material.poisson_ratio.xz, material.poisson_ratio.xy};
  const std::size_t i = axis == 0 ? 1 : 0, j = axis == 2 ? 1 : 2;
  return {E[axis], nu[axis] * std::sqrt(E[j] / E[i]), material.plastic_scale[axis]};
}

mpm::AxisLimits limit_of(const std::optional<shots::ReorientLimit>& given, const mpm::AxisLimits& otherwise) {
  return given ? mpm::AxisLimits{*given->youngs_modulus, *given->poisson_ratio, *given->plastic_scale} : otherwise;
}

/// What is not given comes from the material's axes: z is along the grains, x across, and anywhere lies between.
mpm::Reorientation reorientation_of(const shots::Reorient& asked, const mpm::Material& material) {
  mpm::Reorientation grains;
  grains.length_over_width = *asked.length_over_width;
  grains.parallel = limit_of(asked.parallel, axis_of_material(material, 2));
  grains.perpendicular = limit_of(asked.perpendicular, axis_of_material(material, 0));
  const auto mean = [](double along, double across) { return std::cbrt(along * across * across); };
  const mpm::AxisLimits between = {mean(grains.parallel.youngs_modulus, grains.perpendicular.youngs_modulus),
                                   (grains.parallel.poisson_ratio + 2.0 * grains.perpendicular.poisson_ratio) / 3.0,
                                   mean(grains.parallel.plastic_scale, grains.perpendicular.plastic_scale)};
  grains.isotropic = limit_of(asked.isotropic, between);
  return grains;
}

} // namespace

Result<mpm::Material> compile_matter(const shots::Material& material) {
  const shots::Matter& matter = material.matter;
  mpm::Material compiled;
  compiled.name = *material.name;
  compiled.density = *material.density;
  compiled.elasticity = elasticity(*matter.elasticity);
  compiled.plasticity = plasticity(*matter.plasticity);
  compiled.youngs_modulus = per_axis(matter.youngs_modulus);
  const mpm::PerAxis ratios = per_axis(matter.poisson_ratio);
  compiled.poisson_ratio.yz = ratios[0];
  compiled.poisson_ratio.xz = ratios[1];
  compiled.poisson_ratio.xy = ratios[2];
  if (matter.shear_modulus)
    compiled.shear_modulus =
        mpm::Material::Shear{*(*matter.shear_modulus)[0], *(*matter.shear_modulus)[1], *(*matter.shear_modulus)[2]};
  compiled.plastic_scale = per_axis(matter.plastic_scale);
  if (matter.plastic_map)
    compiled.plastic_map = **matter.plastic_map;
  if (matter.stress_map)
    compiled.stress_map = mandel(**matter.stress_map);
  if (matter.strain_map)
    compiled.strain_map = mandel(**matter.strain_map);
  if (matter.fictitious)
    compiled.fictitious =
        mpm::Material::Isotropic{*matter.fictitious->youngs_modulus, *matter.fictitious->poisson_ratio};
  compiled.frame = frame_mode(*matter.frame);
  compiled.measure = strain_measure(*matter.measure);
  compiled.friction_angle = *matter.friction_angle * RADIANS;
  if (matter.friction_hardening) {
    const std::array<double, 4>& h = **matter.friction_hardening;
    compiled.friction_hardening = {h[0] * RADIANS, h[1] * RADIANS, h[2], h[3] * RADIANS};
  }
  compiled.flow = *matter.flow == shots::PlasticFlow::isochoric ? mpm::Flow::isochoric : mpm::Flow::fictitious;
  compiled.volume_correction = *matter.volume_correction;
  compiled.critical_compression = *matter.critical_compression;
  compiled.critical_stretch = *matter.critical_stretch;
  compiled.snow_hardening = *matter.snow_hardening;
  compiled.shear_limit = *matter.shear_limit;
  if (matter.reorient)
    compiled.reorientation = reorientation_of(*matter.reorient, compiled);
  return compiled;
}

} // namespace wry::pipeline
