#include "pipeline/plan/plan_lines.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/fem/fem_simulation.h"
#include "sim/mpm/grains/sub_particles.h"
#include "sim/mpm/mpm_simulation.h"

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

// Measured on a core with AVX2 (bench_fem_solver, shots/bunny.toml): evaluation and assembly of one Newton iteration
// per tet, and how many iterations a step takes. What its linear system costs is the choice of the solver's to say.
constexpr double CLASSIC_SECONDS_PER_TET = 0.2e-6;
constexpr double MICROPOLAR_SECONDS_PER_TET = 0.6e-6;
constexpr double CURVATURE_SECONDS_PER_TET = 0.7e-6; // beside the former
constexpr double NEWTON_PER_STEP = 3.0;
constexpr double NEWTON_PER_STEP_IN_CONTACT = 20.0; // with both passes of friction
// Element data, two matrices and the vectors, per tet.
constexpr std::uint64_t CLASSIC_BYTES_PER_TET = 1200;
constexpr std::uint64_t MICROPOLAR_BYTES_PER_TET = 4500;
// A step of one particle on one core with AVX2, and what sorting and the grid take of memory besides its channels.
constexpr double MPM_SECONDS_PER_PARTICLE_STEP = 1.5e-7;
constexpr std::uint64_t MPM_BYTES_PER_PARTICLE_BESIDES = 250;

/// What a grid takes on the disk each time that it is kept: nodes about the matter, 16 bytes each and some for blocks.
double bytes_of_fields(const mpm::MpmPlan& plan) {
  constexpr double NODES_PER_CELL = 2.0, BYTES_PER_NODE = 17.0;
  const double cell = plan.settings.cell * plan.settings.cell * plan.settings.cell;
  double cells = 0.0;
  for (const mpm::MpmBody& body : plan.bodies)
    cells += static_cast<double>(body.positions->rows()) * body.particle_volume / cell;
  return NODES_PER_CELL * BYTES_PER_NODE * cells;
}

/// When grains are brought forward, and what it takes to have others.
void describe_grains(ScenePlan& plan) {
  const mpm::MpmPlan& mpm = plan.sim.mpm;
  const bool any = std::any_of(mpm.bodies.begin(), mpm.bodies.end(),
                               [](const mpm::MpmBody& body) { return body.sub_particles.has_value(); });
  if (!any) {
    plan.left_out.push_back({"grains", "no body with sub_particles: none are made or followed"});
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
    plan.left_out.push_back({"fields of grains", "no mpm.keep_fields: other grains (number, seed, shape, size) take "
                                                 "another simulation; it would keep " +
                                                     size});
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
    plan.left_out.push_back({"semi-implicit steps", "no mpm.semi_implicit: no linear solve on the grid"});
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

/// Steps as long as the stiffest material allows at rest.
void add_cost_of_particles(const ScenePlan& plan, CostEstimate& cost) {
  const mpm::MpmPlan& mpm = plan.sim.mpm;
  if (mpm.bodies.empty())
    return;
  mpm::StepFacts facts;
  facts.cell = mpm.settings.cell;
  facts.courant = mpm.settings.courant;
  facts.max_deformation = mpm.settings.max_deformation;
  facts.gravity = mpm.gravity.norm();
  if (mpm.settings.semi_implicit)
    facts.wave_courant = mpm.settings.semi_implicit->courant;
  double particles = 0.0;
  for (std::size_t i = 0; i < mpm.bodies.size(); ++i) {
    const mpm::MpmBody& body = mpm.bodies[i];
    const BodyReport& report = plan.bodies[plan.sim.fem.bodies.size() + i];
    const Result<mpm::CompiledMaterial> material = mpm::compile_material(body.material);
    facts.sound_speed = std::max(facts.sound_speed, material ? material->sound_speed : 0.0);
    facts.speed = std::max(facts.speed, body.initial_velocity.norm());
    particles += static_cast<double>(report.particles);
    cost.memory_bytes += report.particles * (2 * report.bytes_per_particle + MPM_BYTES_PER_PARTICLE_BESIDES);
    cost.bytes_per_frame += report.particles * (24 + 12 + 4);
    if (body.sub_particles)
      cost.bytes_per_frame += report.particles * static_cast<std::uint64_t>(body.sub_particles->per_particle) *
                              mpm::BYTES_PER_GRAIN_AND_FRAME;
    const std::uint64_t scalar = mpm.settings.precision == mpm::Precision::f32 ? 4 : 8;
    cost.bytes_per_checkpoint += report.particles * report.bytes_per_particle * (8 / scalar);
  }
  const mpm::StepBound bound = mpm::stable_step(facts);
  const double dt = mpm.settings.time_step ? std::min(*mpm.settings.time_step, bound.dt) : bound.dt;
  const double steps = std::ceil(plan.sim.time_of(plan.sim.last_frame) / dt);
  const double seconds = cost.steps * cost.seconds_per_step + steps * particles * MPM_SECONDS_PER_PARTICLE_STEP;
  cost.steps = std::max(cost.steps, steps);
  cost.time_step = cost.time_step > 0.0 ? std::min(cost.time_step, dt) : dt;
  cost.seconds_per_step = cost.steps > 0.0 ? seconds / cost.steps : 0.0;
}

void describe_solids(ScenePlan& plan) {
  const fem::FemPlan& fem = plan.sim.fem;
  plan.runs.push_back({"fem", fmt::format("{} bodies, {}, steps of {:.4g} s or less", fem.bodies.size(),
                                          integrator_name(fem.settings.integrator), fem.settings.max_time_step)});
  const bool microrotations = any_body(plan, [](const fem::FemMaterial& m) { return fem::is_micropolar(m.model); });
  const bool curvature =
      any_body(plan, [](const fem::FemMaterial& m) { return m.curvature != fem::CurvatureModel::none; });
  const bool rotary = any_body(plan, [](const fem::FemMaterial& m) { return m.rotary_inertia > 0.0; });
  const auto decide = [&](bool runs, const char* what, const char* why_runs, const char* why_not) {
    (runs ? plan.runs : plan.left_out).push_back({what, runs ? why_runs : why_not});
  };
  decide(microrotations, "microrotations", "a micropolar body: 6 dofs per node",
         "no micropolar body: 3 dofs per node instead of 6");
  decide(curvature, "curvature energy", "a micropolar body with length_scale > 0",
         microrotations ? "length_scale is 0 everywhere: the element kernel without it costs less than half"
                        : "no micropolar body");
  decide(rotary, "rotary inertia", "a material with rotary_inertia > 0", "rotary_inertia is 0 everywhere");
  decide(!fem.planes.empty(), "plane contact", "colliders: barrier and step limit per node",
         "no [[collider]]: no barrier, no step limit");
  const auto rubs = [](const auto& collider) { return collider.friction > 0.0; };
  const bool bodies_rub = fem.contact && (fem.contact->friction.at_rest > 0.0 || !fem.contact->pairs.empty());
  decide(std::any_of(fem.planes.begin(), fem.planes.end(), rubs) ||
             std::any_of(fem.obstacles.begin(), fem.obstacles.end(), rubs) || bodies_rub,
         "friction", "a collider or [contact] with friction > 0", "no friction on colliders or between bodies");
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
         "no [contact]: no broad phase; bodies do not feel each other");
  decide(fem.contact && fem.contact->within_bodies, "contact within bodies",
         "[contact]: the same within each body; pairs that are near at rest feel each other below half of that",
         "no [contact] or within = false: a body that folds passes through itself");
  decide(!fem.driven.empty(), "drives", "[[drive]]: dofs are given by their motion, or pulled by springs",
         "no [[drive]]");
  decide(!fem.loads.empty(), "loads", "[[load]]: forces and torques on nodes", "no [[load]]");
  const bool damped = any_body(plan, [](const fem::FemMaterial& m) { return m.mass_damping > 0.0; });
  decide(damped, "mass damping", "a material with mass_damping > 0", "mass_damping is 0 everywhere");
  const bool stiff_damped = any_body(plan, [](const fem::FemMaterial& m) { return m.stiffness_damping > 0.0; });
  decide(stiff_damped, "stiffness damping",
         "a material with stiffness_damping > 0: a second matrix, assembled once per step",
         "stiffness_damping is 0 everywhere: no second matrix");
  const bool resets = fem.settings.point_rotations != fem::PointRotations::interpolated_velocity;
  if (microrotations)
    decide(resets, "resets of quadrature rotations", "fem.point_rotations: made from the nodes every reset_every steps",
           "fem.point_rotations = \"velocity\": they follow their own history");
  decide(fem.outputs.reactions, "reactions", "a measure of reactions: one more gradient per step",
         "no measure of reactions");
  decide(fem.outputs.point_rotations, "rotations of quadrature points in frames",
         "a measure reads them: 128 bytes per tet and frame", "no measure reads them");
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

CostEstimate estimate_cost(const ScenePlan& plan) {
  CostEstimate cost;
  double seconds_per_iteration = 0.0;
  for (std::size_t i = 0; i < plan.sim.fem.bodies.size(); ++i) {
    const BodyReport& body = plan.bodies[i];
    const bool micropolar = fem::is_micropolar(plan.sim.fem.bodies[i].material.model);
    cost.memory_bytes += body.tets * (micropolar ? MICROPOLAR_BYTES_PER_TET : CLASSIC_BYTES_PER_TET);
    cost.bytes_per_frame += body.nodes * (micropolar ? 64 : 36) + body.tets * 4;
    cost.bytes_per_checkpoint += body.nodes * (micropolar ? 128 : 48) + (micropolar ? body.tets * 128 : 0);
    const bool curved = plan.sim.fem.bodies[i].material.curvature != fem::CurvatureModel::none;
    seconds_per_iteration +=
        static_cast<double>(body.tets) * ((micropolar ? MICROPOLAR_SECONDS_PER_TET : CLASSIC_SECONDS_PER_TET) +
                                          (curved ? CURVATURE_SECONDS_PER_TET : 0.0));
  }
  const fem::FemPlan& fem = plan.sim.fem;
  const bool touches = fem.contact || !fem.planes.empty() || !fem.obstacles.empty();
  const double per_step = (touches ? NEWTON_PER_STEP_IN_CONTACT : NEWTON_PER_STEP) *
                          (fem.settings.integrator == fem::Integrator::sdirk2 ? 2.0 : 1.0);
  cost.seconds_per_step = per_step * seconds_per_iteration;
  if (!plan.sim.fem.bodies.empty()) {
    cost.time_step = plan.sim.fem.settings.max_time_step;
    cost.steps = plan.sim.time_of(plan.sim.last_frame) / cost.time_step;
    cost.newton_directions = per_step * cost.steps;
  }
  add_cost_of_particles(plan, cost);
  return cost;
}

Status describe_solver(ScenePlan& plan, Isa isa, int threads) {
  if (plan.sim.fem.bodies.empty())
    return {};
  const Result<std::unique_ptr<fem::FemSimulation>> simulation = fem::FemSimulation::create(plan.sim.fem, threads, isa);
  if (!simulation)
    return simulation.error();
  const fem::SolverChoice choice = (*simulation)->solver_choice();
  plan.runs.push_back({"linear solver", choice.reason});
  if (plan.cost.steps > 0.0)
    plan.cost.seconds_per_step += plan.cost.newton_directions * choice.seconds_per_direction / plan.cost.steps;
  plan.cost.memory_bytes = std::max<std::uint64_t>(plan.cost.memory_bytes, (*simulation)->memory_bytes());
  return {};
}

} // namespace wry::pipeline
