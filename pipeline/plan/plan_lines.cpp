#include "pipeline/plan/plan_lines.h"

#include <algorithm>

#include <fmt/format.h>

#include "sim/fem/fem_simulation.h"

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

bool any_body(const ScenePlan& plan, bool (*holds)(const fem::FemMaterial&)) {
  return std::any_of(plan.sim.fem.bodies.begin(), plan.sim.fem.bodies.end(),
                     [&](const fem::FemBody& body) { return holds(body.material); });
}

// Measured on a 2-core AVX-512 server over the shipped shots: evaluation, assembly and solve of one Newton iteration
// per tet, and how many iterations a step takes.
constexpr double CLASSIC_SECONDS_PER_TET = 2.0e-6;
constexpr double MICROPOLAR_SECONDS_PER_TET = 8.0e-6;
constexpr double NEWTON_PER_STEP = 4.0;
// Element data, two matrices and the vectors, per tet.
constexpr std::uint64_t CLASSIC_BYTES_PER_TET = 1200;
constexpr std::uint64_t MICROPOLAR_BYTES_PER_TET = 4500;

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

void describe_plan(const shots::Shot& shot, ScenePlan& plan) {
  const fem::FemPlan& fem = plan.sim.fem;
  plan.runs.push_back({"fem", fmt::format("{} bodies, backward Euler, steps of {:.4g} s or less", fem.bodies.size(),
                                          fem.settings.max_time_step)});
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
  decide(std::any_of(fem.planes.begin(), fem.planes.end(), [](const auto& plane) { return plane.friction > 0.0; }),
         "friction", "a collider with friction > 0", "no collider has friction");
  decide(!fem.fixed.empty(), "held nodes", "[[fixed]]: their dofs are taken out of the system", "no [[fixed]]");
  plan.left_out.push_back({"contact of bodies", "no [contact]: no broad phase; bodies do not feel each other"});
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
  for (std::size_t i = 0; i < plan.bodies.size(); ++i) {
    const BodyReport& body = plan.bodies[i];
    const bool micropolar = fem::is_micropolar(plan.sim.fem.bodies[i].material.model);
    cost.memory_bytes += body.tets * (micropolar ? MICROPOLAR_BYTES_PER_TET : CLASSIC_BYTES_PER_TET);
    cost.bytes_per_frame += body.nodes * (micropolar ? 64 : 36) + body.tets * 4;
    cost.bytes_per_checkpoint += body.nodes * (micropolar ? 128 : 48) + (micropolar ? body.tets * 128 : 0);
    seconds_per_iteration +=
        static_cast<double>(body.tets) * (micropolar ? MICROPOLAR_SECONDS_PER_TET : CLASSIC_SECONDS_PER_TET);
  }
  cost.seconds_per_step = NEWTON_PER_STEP * seconds_per_iteration;
  cost.steps = plan.sim.time_of(plan.sim.last_frame) / plan.sim.fem.settings.max_time_step;
  return cost;
}

Status describe_solver(ScenePlan& plan, Isa isa, int threads) {
  const Result<std::unique_ptr<fem::FemSimulation>> simulation = fem::FemSimulation::create(plan.sim.fem, threads, isa);
  if (!simulation)
    return simulation.error();
  plan.runs.push_back({"linear solver", (*simulation)->solver_choice().reason});
  plan.cost.memory_bytes = std::max<std::uint64_t>(plan.cost.memory_bytes, (*simulation)->memory_bytes());
  return {};
}

} // namespace wry::pipeline
