#include "pipeline/plan/plan_lines.h"

#include <algorithm>

#include <fmt/format.h>

#include "pipeline/plan/cost.h"
#include "pipeline/plan/left_out_parts.h"

namespace wry::pipeline {

namespace {

const char* model_name(fem::ElasticModel model) {
  switch (model) {
  case fem::ElasticModel::neo_hookean:
    return "neo-hookean";
  case fem::ElasticModel::neo_hookean_eq16:
    return "neo-hookean-eq16";
  case fem::ElasticModel::stvk:
    return "stvk";
  case fem::ElasticModel::corotated:
    return "corotated";
  case fem::ElasticModel::micropolar:
    return "micropolar";
  case fem::ElasticModel::micropolar_det:
    return "micropolar-det";
  case fem::ElasticModel::micropolar_neo_hookean:
    return "micropolar-neo-hookean";
  }
  return "?";
}

const char* integrator_name(fem::Integrator integrator) {
  switch (integrator) {
  case fem::Integrator::backward_euler:
    return "backward Euler";
  case fem::Integrator::bdf2:
    return "BDF2";
  case fem::Integrator::sdirk2:
    return "SDIRK2, two solves per step";
  }
  return "?";
}

bool any_body(const ScenePlan& plan, bool (*holds)(const fem::FemMaterial&)) {
  return std::any_of(plan.sim.fem.bodies.begin(), plan.sim.fem.bodies.end(),
                     [&](const fem::FemBody& body) { return holds(body.material); });
}

/// When grains are brought forward, and what it takes to have others.
void describe_grains(ScenePlan& plan) {
  const mpm::MpmPlan& mpm = plan.sim.mpm;
  const bool any = std::any_of(mpm.bodies.begin(), mpm.bodies.end(),
                               [](const mpm::MpmBody& body) { return body.sub_particles.has_value(); });
  if (!any) {
    plan.left_out.push_back({"grains", "no body with sub_particles: none are made or followed", with_grains});
    return;
  }
  plan.runs.push_back(
      {"grains", "sub_particles: brought forward with the grid of some steps, as often as travel says"});
  const std::string size =
      fmt::format("{:.2g} MB or more each time, several times a frame", 1e-6 * bytes_of_fields(mpm));
  if (mpm.settings.keep_fields)
    plan.runs.push_back({"fields of grains", "mpm.keep_fields: the grid that carries grains is kept, " + size +
                                                 "; other grains are then made without simulating"});
  else
    plan.left_out.push_back({"fields of grains",
                             "no mpm.keep_fields: other grains (number, seed, shape, size) take "
                             "another simulation; it would keep " +
                                 size,
                             with_kept_fields});
}

/// What the materials of particles leave out.
void describe_matter(ScenePlan& plan) {
  for (const mpm::MpmBody& body : plan.sim.mpm.bodies) {
    const Result<mpm::CompiledMaterial> material = mpm::compile_material(body.material);
    if (!material)
      continue;
    for (const mpm::LeftOut& part : material->left_out) {
      PlanLine line{fmt::format("{} of {}", part.what, body.name), part.why};
      if (part.part != mpm::LeftOut::Part::maps_of_each_particle) // they come with second moments
        line.with = [name = body.name, kind = part.part](ScenePlan& other) { put_in(other, name, kind); };
      plan.left_out.push_back(std::move(line));
    }
  }
}

/// Which methods run, and that nothing couples them.
void describe_methods(ScenePlan& plan) {
  const mpm::MpmPlan& mpm = plan.sim.mpm;
  if (mpm.bodies.empty()) {
    plan.left_out.push_back({"mpm", "no body of particles: no grid"});
    return;
  }
  const std::string step = mpm.settings.time_step
                               ? fmt::format("steps of {:.4g} s, cut where unstable", *mpm.settings.time_step)
                               : std::string("the longest stable step");
  plan.runs.push_back(
      {"mpm", fmt::format("{} bodies, cells of {:.4g} m, {}, {}, {}", mpm.bodies.size(), mpm.settings.cell,
                          mpm.settings.precision == mpm::Precision::f32 ? "single precision" : "double precision",
                          mpm.settings.transfer == mpm::Transfer::mls ? "moving least squares" : "gradient of weights",
                          step)});
  const auto decide = [&](bool runs, const char* what, const char* why_runs, const char* why_not) {
    (runs ? plan.runs : plan.left_out).push_back({what, runs ? why_runs : why_not});
  };
  if (mpm.settings.semi_implicit)
    plan.runs.push_back({"semi-implicit steps",
                         fmt::format("mpm.semi_implicit: waves may cross {:.3g} cells in a step; a solve by conjugate "
                                     "gradients in each, implicitness {:.3g}, damping {:.3g}",
                                     mpm.settings.semi_implicit->courant, mpm.settings.semi_implicit->implicitness,
                                     mpm.settings.semi_implicit->damping)});
  else
    plan.left_out.push_back({"semi-implicit steps",
                             "no mpm.semi_implicit: no linear solve on the grid, no waves damped",
                             with_semi_implicit_steps});
  if (mpm.settings.precision == mpm::Precision::f32)
    plan.left_out.push_back({"double precision", "mpm.precision is f32", with_double_precision});
  describe_matter(plan);
  decide(!mpm.colliders.empty(), "colliders on the grid", "[[collider]]: nodes of blocks that are near one",
         "no [[collider]]: no node is looked at");
  decide(!mpm.held.empty(), "held space", "[[fixed]] and [[drive]] on a body of particles",
         "no [[fixed]] or [[drive]] on a body of particles");
  describe_grains(plan);
  decide(!mpm.sources.empty(), "sources", "a body with source", "no body with source: no particle is added");
  if (plan.sim.fem.bodies.empty())
    plan.left_out.push_back({"fem", "no solid: no elements, no linear solver"});
  else
    plan.left_out.push_back(
        {"coupling", "solids and particles do not feel each other; they share colliders and frames"});
}

void describe_solids(ScenePlan& plan) {
  const fem::FemPlan& fem = plan.sim.fem;
  plan.runs.push_back({"fem", fmt::format("{} bodies, {}, steps of {:.4g} s or less", fem.bodies.size(),
                                          integrator_name(fem.settings.integrator), fem.settings.max_time_step)});
  const bool microrotations = any_body(plan, [](const fem::FemMaterial& m) { return fem::is_micropolar(m.model); });
  const bool curvature =
      any_body(plan, [](const fem::FemMaterial& m) { return m.curvature != fem::CurvatureModel::none; });
  const bool rotary = any_body(plan, [](const fem::FemMaterial& m) { return m.rotary_inertia > 0.0; });
  using With = void (*)(ScenePlan&);
  const auto decide = [&](bool runs, const char* what, const char* why_runs, const char* why_not, With with = nullptr) {
    (runs ? plan.runs : plan.left_out).push_back({what, runs ? why_runs : why_not, runs ? nullptr : with});
  };
  decide(microrotations, "microrotations", "a micropolar body: 6 dofs per node",
         "no micropolar body: 3 dofs per node instead of 6", with_microrotations);
  decide(curvature, "curvature energy", "a micropolar body with length_scale > 0",
         microrotations ? "length_scale is 0 everywhere: the element kernel without it costs less than half"
                        : "no micropolar body",
         with_curvature);
  decide(rotary, "rotary inertia", "a material with rotary_inertia > 0", "rotary_inertia is 0 everywhere");
  decide(!fem.planes.empty(), "plane contact", "colliders: barrier and step limit per node",
         "no [[collider]]: no barrier, no step limit", with_plane);
  const auto rubs = [](const auto& collider) { return collider.friction > 0.0; };
  const bool touches = fem.contact || !fem.planes.empty() || !fem.obstacles.empty();
  const bool bodies_rub = fem.contact && (fem.contact->friction.at_rest > 0.0 || !fem.contact->pairs.empty());
  decide(std::any_of(fem.planes.begin(), fem.planes.end(), rubs) ||
             std::any_of(fem.obstacles.begin(), fem.obstacles.end(), rubs) || bodies_rub,
         "friction", "a collider or [contact] with friction > 0", "no friction on colliders or between bodies",
         touches ? with_friction : nullptr);
  decide(!fem.fixed.empty(), "held nodes", "[[fixed]]: their dofs are taken out of the system", "no [[fixed]]");
  decide(!fem.obstacles.empty(), "collider contact",
         "colliders other than planes: barrier between surfaces, steps limited by continuous collision detection",
         "no collider but planes: no broad phase for colliders");
  const auto deforms = [](const scene::Collider& collider) { return collider.sequence() != nullptr; };
  decide(std::any_of(fem.obstacles.begin(), fem.obstacles.end(), deforms), "colliders that deform",
         "[[collider]] sequence: vertices go straight from step to step, checked along the whole way",
         "no [[collider]] with a sequence");
  decide(fem.contact && fem.contact->between_bodies, "contact of bodies",
         "[contact]: barrier between surfaces, steps limited by continuous collision detection",
         "no [contact]: no broad phase; bodies do not feel each other",
         fem.bodies.size() > 1 ? with_contact_of_bodies : nullptr);
  decide(fem.contact && fem.contact->within_bodies, "contact within bodies",
         "[contact]: the same within each body; pairs that are near at rest feel each other below half of that",
         "no [contact] or within = false: a body that folds passes through itself", with_contact_within_bodies);
  decide(!fem.driven.empty(), "drives", "[[drive]]: dofs are given by their motion, or pulled by springs",
         "no [[drive]]");
  decide(!fem.loads.empty(), "loads", "[[load]]: forces and torques on nodes", "no [[load]]");
  const bool damped = any_body(plan, [](const fem::FemMaterial& m) { return m.mass_damping > 0.0; });
  decide(damped, "mass damping", "a material with mass_damping > 0", "mass_damping is 0 everywhere");
  const bool stiff_damped = any_body(plan, [](const fem::FemMaterial& m) { return m.stiffness_damping > 0.0; });
  decide(stiff_damped, "stiffness damping",
         "a material with stiffness_damping > 0: a second matrix, assembled once per step",
         "stiffness_damping is 0 everywhere: no second matrix", with_stiffness_damping);
  const bool resets = fem.settings.point_rotations != fem::PointRotations::interpolated_velocity;
  if (microrotations)
    decide(resets, "resets of quadrature rotations", "fem.point_rotations: made from the nodes every reset_every steps",
           "fem.point_rotations = \"velocity\": they follow their own history");
  decide(fem.outputs.reactions, "reactions", "a measure of reactions: one more gradient per step",
         "no measure of reactions", with_reactions);
  decide(fem.outputs.point_rotations, "rotations of quadrature points in frames",
         "a measure reads them: 128 bytes per tet and frame", "no measure reads them",
         microrotations ? with_point_rotations : nullptr);
}

} // namespace

std::string describe_material(const fem::FemMaterial& material) {
  std::string text = fmt::format("{} ({}), E {:.4g} Pa, nu {:.4g}, density {:.4g} kg/m^3", model_name(material.model),
                                 material.name, material.youngs_modulus, material.poisson_ratio, material.density);
  if (!fem::is_micropolar(material.model))
    return text;
  text += fmt::format(", mu_c/mu {:.4g}", material.couple_modulus_ratio);
  if (material.curvature == fem::CurvatureModel::isotropic)
    text += fmt::format(", L_c {:.4g} m, isotropic curvature alpha {:.4g} beta {:.4g} gamma {:.4g}",
                        material.length_scale, material.alpha, material.beta, material.gamma);
  if (material.curvature == fem::CurvatureModel::orthotropic)
    text += fmt::format(", L_c {:.4g} m, orthotropic curvature", material.length_scale);
  return text;
}

std::string describe_elements(const fem::FemBody& body) {
  switch (body.element) {
  case fem::ElementKind::tet4:
    return "";
  case fem::ElementKind::tet4_one_point:
    return ", one quadrature point per tet";
  case fem::ElementKind::tet10:
    return ", tet10: quadratic positions";
  case fem::ElementKind::plate3:
  case fem::ElementKind::plate6:
    return fmt::format(", plate {:.4g} m thick, {} triangles {}, bending {}", body.thickness, body.triangles.rows(),
                       body.element == fem::ElementKind::plate3 ? "tri3" : "tri6",
                       body.material.plate_bending == fem::PlateBending::h3 ? "h3" : "curv");
  }
  return "";
}

void describe_plan(const shots::Shot& shot, ScenePlan& plan) {
  const fem::FemPlan& fem = plan.sim.fem;
  describe_methods(plan);
  const auto decide = [&](bool runs, const char* what, const char* why_runs, const char* why_not) {
    (runs ? plan.runs : plan.left_out).push_back({what, runs ? why_runs : why_not});
  };
  if (!fem.bodies.empty())
    describe_solids(plan);
  decide(!plan.measures.empty(), "measures", "[[measure]]: once per frame, from the cache", "no [[measure]]");
  std::string views;
  for (const shots::Located<shots::View>& view : shot.render.views)
    views += (views.empty() ? "" : ", ") + view->name;
  plan.runs.push_back(
      {"pictures", fmt::format("{} frames, views {}, {} sub-frames", plan.frames.size(), views, *shot.render.samples)});
}

} // namespace wry::pipeline
