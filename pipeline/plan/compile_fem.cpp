#include "pipeline/plan/compile_fem.h"

#include <algorithm>
#include <cmath>

namespace wry::pipeline {

namespace {

// The paper's own step; longer ones save little because Newton then needs more iterations.
constexpr double AUTOMATIC_TIME_STEP = 0.01;

fem::ElasticModel elastic_model(shots::MaterialModel model) {
  switch (model) {
  case shots::MaterialModel::neo_hookean:
    return fem::ElasticModel::neo_hookean;
  case shots::MaterialModel::neo_hookean_eq16:
    return fem::ElasticModel::neo_hookean_eq16;
  case shots::MaterialModel::stvk:
    return fem::ElasticModel::stvk;
  case shots::MaterialModel::corotated:
    return fem::ElasticModel::corotated;
  case shots::MaterialModel::micropolar:
    return fem::ElasticModel::micropolar;
  case shots::MaterialModel::micropolar_det:
    return fem::ElasticModel::micropolar_det;
  case shots::MaterialModel::micropolar_neo_hookean:
    return fem::ElasticModel::micropolar_neo_hookean;
  case shots::MaterialModel::plate: // the elements make the difference
    return fem::ElasticModel::micropolar;
  case shots::MaterialModel::mpm: // no body of it comes here
    break;
  }
  return fem::ElasticModel::neo_hookean;
}

fem::LinearSolver linear_solver(shots::LinearSolver solver) {
  switch (solver) {
  case shots::LinearSolver::automatic:
    return fem::LinearSolver::automatic;
  case shots::LinearSolver::pcg:
    return fem::LinearSolver::pcg;
  case shots::LinearSolver::cholesky:
    return fem::LinearSolver::cholesky;
  case shots::LinearSolver::stale_cholesky:
    return fem::LinearSolver::stale_cholesky;
  }
  return fem::LinearSolver::automatic;
}

fem::Friction compile_friction(const shots::FrictionOptions& options) {
  const double at_rest = *options.friction;
  return {at_rest, options.sliding_friction ? **options.sliding_friction : at_rest};
}

fem::Integrator integrator(shots::Integrator integrator) {
  switch (integrator) {
  case shots::Integrator::backward_euler:
    return fem::Integrator::backward_euler;
  case shots::Integrator::bdf2:
    return fem::Integrator::bdf2;
  case shots::Integrator::sdirk2:
    return fem::Integrator::sdirk2;
  }
  return fem::Integrator::backward_euler;
}

fem::PointRotations point_rotations(shots::PointRotations rule) {
  switch (rule) {
  case shots::PointRotations::velocity:
    return fem::PointRotations::interpolated_velocity;
  case shots::PointRotations::rotation_vectors:
    return fem::PointRotations::rotation_vectors;
  case shots::PointRotations::quaternion_blend:
    return fem::PointRotations::quaternion_blend;
  case shots::PointRotations::spherical:
    return fem::PointRotations::spherical_average;
  }
  return fem::PointRotations::interpolated_velocity;
}

} // namespace

std::optional<fem::ContactOptions> compile_contact(const std::optional<shots::ContactOptions>& contact) {
  if (!contact)
    return std::nullopt;
  fem::ContactOptions compiled;
  compiled.between_bodies = *contact->between;
  compiled.within_bodies = *contact->within;
  compiled.friction = compile_friction(contact->friction);
  for (const shots::ContactPairOptions& pair : contact->pairs)
    compiled.pairs.push_back({*pair.first, *pair.second, compile_friction(pair.friction)});
  return compiled;
}

Error at_source(const shots::Source& source, Error error) {
  error.message = source.text() + ": " + error.message;
  return error;
}

Vec3 axis_vector(shots::Axis axis) {
  return Vec3::Unit(static_cast<int>(axis));
}

fem::FemMaterial compile_material(const shots::Material& material) {
  fem::FemMaterial compiled;
  compiled.name = *material.name;
  compiled.model = elastic_model(*material.model);
  compiled.density = *material.density;
  compiled.youngs_modulus = *material.youngs_modulus;
  compiled.poisson_ratio = *material.poisson_ratio;
  compiled.couple_modulus_ratio = *material.couple_modulus_ratio;
  compiled.length_scale = *material.length_scale;
  compiled.rotary_inertia = *material.rotary_inertia;
  compiled.plate_bending =
      *material.bending == shots::PlateBending::h3 ? fem::PlateBending::h3 : fem::PlateBending::curv;
  if (material.max_stretch)
    compiled.max_stretch = **material.max_stretch;
  compiled.mass_damping = *material.mass_damping;
  compiled.stiffness_damping = *material.stiffness_damping;
  compiled.alpha = *material.curvature.alpha;
  compiled.beta = *material.curvature.beta;
  compiled.gamma = *material.curvature.gamma;
  compiled.curvature_basis = *material.curvature.basis;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      compiled.curvature_stiffness(i, j) = *material.curvature.stiffness[i][j];
  }
  const bool has_curvature = fem::is_micropolar(compiled.model) && compiled.length_scale > 0.0;
  if (!has_curvature)
    compiled.curvature = fem::CurvatureModel::none;
  else if (*material.curvature.model == shots::CurvatureModel::isotropic)
    compiled.curvature = fem::CurvatureModel::isotropic;
  else
    compiled.curvature = fem::CurvatureModel::orthotropic;
  return compiled;
}

fem::FemSettings compile_fem_settings(const shots::FemOptions& options, double fps) {
  fem::FemSettings settings;
  // A whole number of steps per frame, so that no step is cut short to land on one.
  const double frame_time = 1.0 / fps;
  settings.max_time_step =
      options.time_step ? **options.time_step : frame_time / std::max(1.0, std::ceil(frame_time / AUTOMATIC_TIME_STEP));
  settings.min_time_step = *options.min_time_step;
  settings.integrator = integrator(*options.integrator);
  settings.rotation_update = *options.rotation_update == shots::RotationUpdate::exponential
                                 ? fem::RotationUpdate::exponential
                                 : fem::RotationUpdate::cayley;
  settings.point_rotations = point_rotations(*options.point_rotations);
  settings.reset_every = static_cast<int>(*options.reset_every);
  settings.newton_tolerance = *options.newton_tolerance;
  settings.max_newton_iterations = static_cast<int>(*options.max_newton_iterations);
  settings.linear_solver = linear_solver(*options.linear_solver);
  settings.linear_tolerance = options.linear_tolerance ? **options.linear_tolerance : 0.0;
  if (options.contact_distance)
    settings.contact_distance = **options.contact_distance;
  if (options.contact_stiffness)
    settings.contact_stiffness = **options.contact_stiffness;
  settings.friction_velocity = *options.friction_velocity;
  return settings;
}

} // namespace wry::pipeline
