#include "pipeline/plan/scene_plan.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "pipeline/cache/sha256.h"
#include "pipeline/plan/build_id.h"
#include "pipeline/plan/compile_collider.h"
#include "pipeline/plan/compile_fem.h"
#include "pipeline/plan/compile_region.h"
#include "pipeline/plan/mesh_body.h"
#include "pipeline/plan/plan_lines.h"
#include "shots/resolved.h"
#include "sim/base/parallel.h"

namespace wry::pipeline {

namespace {

/// Compiles one shot, part by part, each into the plan.
class SceneCompiler {
public:
  SceneCompiler(const shots::Shot& shot, const PlanOptions& options)
      : m_shot(shot)
      , m_options(options) {}

  Result<ScenePlan> compile() {
    m_plan.name = *m_shot.shot.name;
    m_plan.frames = m_options.frames;
    m_plan.sim.fps = *m_shot.shot.fps;
    m_plan.sim.first_frame = m_shot.shot.frames->first();
    m_plan.sim.last_frame = m_options.frames.back();
    m_plan.sim.up = axis_vector(*m_shot.shot.up);
    m_plan.sim.fem.gravity = *m_shot.shot.gravity;
    m_plan.sim.fem.settings = compile_fem_settings(m_shot.fem, m_plan.sim.fps);
    using Part = Status (SceneCompiler::*)();
    for (const Part part : {&SceneCompiler::compile_bodies, &SceneCompiler::compile_fixed,
                            &SceneCompiler::compile_colliders, &SceneCompiler::compile_measures}) {
      if (Status status = (this->*part)(); !status)
        return status.error();
    }
    m_plan.simulation_key = simulation_key();
    m_plan.cost = estimate_cost(m_plan);
    describe_plan(m_shot, m_plan);
    return std::move(m_plan);
  }

private:
  Status compile_bodies();
  Status compile_fixed();
  Status compile_colliders();
  Status compile_measures();
  std::string simulation_key() const;
  std::size_t body_index(const std::string& name) const;

  const shots::Shot& m_shot;
  const PlanOptions& m_options;
  Threads m_threads{1};
  ScenePlan m_plan;
};

std::size_t SceneCompiler::body_index(const std::string& name) const {
  const auto& bodies = m_plan.sim.fem.bodies;
  return static_cast<std::size_t>(
      std::find_if(bodies.begin(), bodies.end(), [&](const fem::FemBody& body) { return body.name == name; }) -
      bodies.begin());
}

Status SceneCompiler::compile_bodies() {
  if (m_shot.bodies.empty())
    return make_error(ErrorCode::bad_input, "{}: there is no [[body]], so there is nothing to simulate", m_shot.file);
  for (const shots::Body& body : m_shot.bodies) {
    Result<MeshedBody> meshed = mesh_body(body, *m_shot.shot.up);
    if (!meshed)
      return meshed.error();
    const shots::Material& material = *m_shot.find_material(*body.material);
    fem::FemBody compiled;
    compiled.name = *body.name;
    compiled.mesh = meshed->mesh;
    compiled.material = compile_material(material);
    compiled.initial_velocity = *body.velocity;
    Result<fem::RestCurvature> rest_curvature = compile_rest_curvature(material);
    if (!rest_curvature)
      return rest_curvature.error();
    compiled.rest_curvature = std::move(*rest_curvature);
    BodyReport& report = meshed->report;
    report.model = describe_material(compiled.material);
    report.dofs = report.nodes * (fem::is_micropolar(compiled.material.model) ? 6 : 3);
    report.mass = report.volume * compiled.material.density;
    m_plan.bodies.push_back(std::move(report));
    m_plan.body_looks.push_back(body.look ? **body.look : std::string());
    m_plan.assets.insert(m_plan.assets.end(), meshed->assets.begin(), meshed->assets.end());
    m_plan.sim.fem.bodies.push_back(std::move(compiled));
  }
  return {};
}

Status SceneCompiler::compile_fixed() {
  for (const shots::Fixed& fixed : m_shot.fixed) {
    fem::FixedNodes nodes;
    nodes.name = *fixed.name;
    nodes.body = static_cast<int>(body_index(*fixed.body));
    nodes.hold_positions = *fixed.hold_positions;
    nodes.hold_microrotations = *fixed.hold_microrotations;
    if (fixed.until)
      nodes.until = **fixed.until;
    const geometry::TetMesh& mesh = *m_plan.sim.fem.bodies[static_cast<std::size_t>(nodes.body)].mesh;
    Result<std::vector<std::int32_t>> picked =
        scene::select_points(compile_region(fixed.where), scene::rest_points(mesh), m_threads);
    if (!picked)
      return at_source(fixed.source, picked.error());
    nodes.nodes = std::move(*picked);
    m_plan.sim.fem.fixed.push_back(std::move(nodes));
  }
  return {};
}

Status SceneCompiler::compile_colliders() {
  for (const shots::Collider& asked : m_shot.colliders) {
    Result<CompiledCollider> compiled = compile_collider(asked, *m_shot.shot.up);
    if (!compiled)
      return compiled.error();
    const scene::Collider& collider = *compiled->collider;
    const auto* plane = std::get_if<scene::PlaneObstacle>(&collider.shape);
    if (plane != nullptr && !collider.motion.moves())
      m_plan.sim.fem.planes.push_back({collider.name, collider.motion.pose(0.0).apply(plane->point),
                                       collider.motion.pose(0.0).rotation * plane->normal, collider.friction});
    else if (!m_plan.sim.fem.bodies.empty())
      return at_source(asked.source, make_error(ErrorCode::unavailable,
                                                "solids only know planes that stand still; this build has no contact "
                                                "with other colliders"));
    m_plan.assets.insert(m_plan.assets.end(), compiled->assets.begin(), compiled->assets.end());
    m_plan.sim.colliders.push_back(std::move(compiled->collider));
  }
  return {};
}

Status SceneCompiler::compile_measures() {
  for (const shots::Measure& measure : m_shot.measures) {
    MeasurePlan compiled;
    compiled.name = *measure.name;
    compiled.kind = *measure.kind;
    compiled.body = body_index(*measure.body);
    compiled.density = m_plan.sim.fem.bodies[compiled.body].material.density;
    compiled.direction = measure.axis ? axis_vector(**measure.axis) : m_plan.sim.up;
    if (measure.where) {
      const scene::RestPoints points = scene::rest_points(*m_plan.sim.fem.bodies[compiled.body].mesh);
      Result<std::vector<std::int32_t>> picked =
          scene::select_points(compile_region(*measure.where), points, m_threads);
      if (!picked)
        return at_source(measure.source, picked.error());
      compiled.nodes = std::move(*picked);
    }
    m_plan.measures.push_back(std::move(compiled));
    m_plan.measure_is_relative.push_back(*measure.relative);
  }
  return {};
}

std::string SceneCompiler::simulation_key() const {
  std::string inputs = fmt::format("{} {}\n", simulation_build(), isa_name(m_options.isa));
  for (const shots::FlatKey& key : shots::flatten(m_shot)) {
    if (key.effect == shots::Effect::simulation)
      inputs += key.key + "=" + key.value + "\n";
  }
  for (const Asset& asset : m_plan.assets)
    inputs += asset.sha256 + "\n";
  return sha256_of_bytes(inputs);
}

} // namespace

Result<ScenePlan> compile_scene(const shots::Shot& shot, const PlanOptions& options) {
  return SceneCompiler(shot, options).compile();
}

} // namespace wry::pipeline
