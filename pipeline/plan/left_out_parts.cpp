#include "pipeline/plan/left_out_parts.h"

#include <algorithm>

#include "sim/mpm/mpm_simulation.h"

namespace wry::pipeline {

namespace {

fem::ContactOptions& contact_of(ScenePlan& plan) {
  if (!plan.sim.fem.contact)
    plan.sim.fem.contact =
        fem::ContactOptions{.between_bodies = false, .within_bodies = false, .friction = {}, .pairs = {}};
  return *plan.sim.fem.contact;
}

/// Brings the reports of particles up to date with their materials.
void count_bytes(ScenePlan& plan) {
  const mpm::MpmPlan& mpm = plan.sim.mpm;
  for (std::size_t i = 0; i < mpm.bodies.size(); ++i) {
    const Result<mpm::ParticleCost> cost = mpm::particle_cost(mpm.bodies[i].material, mpm.settings.precision);
    if (cost)
      plan.bodies[plan.sim.fem.bodies.size() + i].bytes_per_particle = cost->bytes;
  }
}

void reorient(mpm::Material& material) {
  mpm::AxisLimits limits;
  limits.youngs_modulus = *std::max_element(material.youngs_modulus.begin(), material.youngs_modulus.end());
  limits.poisson_ratio = material.poisson_ratio.yz;
  material.reorientation = mpm::Reorientation{.isotropic = limits, .parallel = limits, .perpendicular = limits};
}

} // namespace

void with_microrotations(ScenePlan& plan) {
  for (fem::FemBody& body : plan.sim.fem.bodies) {
    if (body.element == fem::ElementKind::tet4 && !fem::is_micropolar(body.material.model))
      body.material.model = fem::ElasticModel::micropolar;
  }
}

void with_curvature(ScenePlan& plan) {
  constexpr double SHARE_OF_SIZE = 0.1;
  with_microrotations(plan);
  for (std::size_t i = 0; i < plan.sim.fem.bodies.size(); ++i) {
    fem::FemMaterial& material = plan.sim.fem.bodies[i].material;
    if (!fem::is_micropolar(material.model))
      continue;
    material.curvature = fem::CurvatureModel::isotropic;
    if (material.length_scale == 0.0)
      material.length_scale = SHARE_OF_SIZE * plan.bodies[i].size.maxCoeff();
  }
}

void with_plane(ScenePlan& plan) {
  plan.sim.fem.planes.push_back({"plane", Vec3::Zero(), plan.sim.up, 0.0});
}

void with_friction(ScenePlan& plan) {
  constexpr double COEFFICIENT = 0.5;
  for (scene::PlaneCollider& plane : plan.sim.fem.planes)
    plane.friction = COEFFICIENT;
  for (scene::Collider& obstacle : plan.sim.fem.obstacles)
    obstacle.friction = COEFFICIENT;
  if (plan.sim.fem.contact)
    contact_of(plan).friction = {COEFFICIENT, COEFFICIENT};
}

void with_contact_of_bodies(ScenePlan& plan) {
  contact_of(plan).between_bodies = true;
}

void with_contact_within_bodies(ScenePlan& plan) {
  contact_of(plan).within_bodies = true;
}

void with_stiffness_damping(ScenePlan& plan) {
  constexpr double SECONDS = 1e-3;
  for (fem::FemBody& body : plan.sim.fem.bodies)
    body.material.stiffness_damping = SECONDS;
}

void with_reactions(ScenePlan& plan) {
  plan.sim.fem.outputs.reactions = true;
}

void with_point_rotations(ScenePlan& plan) {
  plan.sim.fem.outputs.point_rotations = true;
}

void with_double_precision(ScenePlan& plan) {
  plan.sim.mpm.settings.precision = mpm::Precision::f64;
  count_bytes(plan);
}

void with_semi_implicit_steps(ScenePlan& plan) {
  plan.sim.mpm.settings.semi_implicit = mpm::SemiImplicit{};
}

void with_grains(ScenePlan& plan) {
  for (mpm::MpmBody& body : plan.sim.mpm.bodies) {
    if (!body.sub_particles)
      body.sub_particles.emplace();
  }
}

void with_kept_fields(ScenePlan& plan) {
  plan.sim.mpm.settings.keep_fields = true;
}

void put_in(ScenePlan& plan, const std::string& body, mpm::LeftOut::Part part) {
  using Part = mpm::LeftOut::Part;
  for (mpm::MpmBody& other : plan.sim.mpm.bodies) {
    if (other.name != body)
      continue;
    mpm::Material& material = other.material;
    switch (part) {
    case Part::frames_and_maps:
    case Part::maps:
      material.plastic_scale = {0.9, 1.0, 1.1}; // whatever differs from axis to axis
      if (part == Part::maps)
        material.elasticity = mpm::Elasticity::hencky;
      break;
    case Part::second_moment:
    case Part::maps_of_each_particle: // they come together
      reorient(material);
      break;
    case Part::hardening:
      material.friction_hardening = {0.6, 0.0, 0.2, 0.0};
      break;
    }
  }
  count_bytes(plan);
}

} // namespace wry::pipeline
