#include "pipeline/measure/grain_measures.h"
#include "pipeline/plan/scene_plan.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "pipeline/cache/sha256.h"
#include "pipeline/plan/build_id.h"
#include "pipeline/plan/compile_boundary.h"
#include "pipeline/plan/compile_collider.h"
#include "pipeline/plan/compile_fem.h"
#include "pipeline/plan/compile_fields.h"
#include "pipeline/plan/compile_mpm.h"
#include "pipeline/plan/compile_region.h"
#include "pipeline/plan/cost.h"
#include "pipeline/plan/element_warnings.h"
#include "pipeline/plan/microrotations.h"
#include "pipeline/plan/plan_lines.h"
#include "pipeline/plan/shared_mesh.h"
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
    m_plan.sim.fem.contact = compile_contact(m_shot.contact);
    using Part = Status (SceneCompiler::*)();
    for (const Part part :
         {&SceneCompiler::compile_bodies, &SceneCompiler::compile_particle_bodies, &SceneCompiler::compile_fixed,
          &SceneCompiler::compile_colliders, &SceneCompiler::compile_drives, &SceneCompiler::compile_measures}) {
      if (Status status = (this->*part)(); !status)
        return status.error();
    }
    for (const shots::Located<shots::View>& view : m_shot.render.views) {
      if (view->channel == "curvature_energy_density")
        m_plan.sim.fem.outputs.curvature_energy = true;
    }
    m_plan.simulation_key = key_of(Inputs::all);
    m_plan.matter_key = key_of(Inputs::matter);
    m_plan.assets.insert(m_plan.assets.end(), m_grain_assets.begin(), m_grain_assets.end());
    m_plan.cost = estimate_cost(m_shot, m_plan);
    describe_plan(m_shot, m_plan);
    return std::move(m_plan);
  }

private:
  Status compile_bodies();
  Status compile_particle_bodies();
  Status compile_fixed();
  Status compile_colliders();
  Status compile_drives();
  Status compile_measures();
  Status describe_measured_body(const shots::Measure& measure, MeasurePlan& compiled) const;
  scene::RestPoints measured_points(std::size_t body) const;
  enum class Inputs { all, matter };
  std::string key_of(Inputs what) const;

  const shots::Shot& m_shot;
  const PlanOptions& m_options;
  Threads m_threads{1};
  std::vector<Asset> m_grain_assets; ///< the plan's when its keys are made
  ScenePlan m_plan;
};

/// The body's elements, once its material and mesh are set; midpoints are added where they are quadratic.
void set_elements(const shots::Body& body, const shots::Material& material, const MeshedBody& meshed,
                  fem::FemBody& compiled) {
  using shots::Element;
  const bool plate = *material.model == shots::MaterialModel::plate;
  if (*body.quadrature == shots::Quadrature::one_point)
    compiled.element = fem::ElementKind::tet4_one_point;
  if (plate) {
    compiled.element = fem::ElementKind::plate3;
    compiled.triangles = meshed.triangles;
    compiled.thickness = material.thickness ? **material.thickness : meshed.sheet_thickness;
  }
  const bool quadratic = plate ? *body.element != Element::tri3 : *body.element == Element::tet10;
  if (quadratic)
    compiled = fem::with_midpoints(std::move(compiled));
}

double area_of(const geometry::TetMesh& mesh, const Triangles& triangles) {
  double area = 0.0;
  for (Eigen::Index i = 0; i < triangles.rows(); ++i) {
    const Vec3 origin = mesh.vertices.row(triangles(i, 0));
    const Vec3 a = mesh.vertices.row(triangles(i, 1)).transpose() - origin;
    const Vec3 b = mesh.vertices.row(triangles(i, 2)).transpose() - origin;
    area += 0.5 * a.cross(b).norm();
  }
  return area;
}

std::size_t count_unknowns(const fem::FemBody& body) {
  const auto nodes = static_cast<std::size_t>(body.mesh->vertices.rows());
  if (!fem::is_micropolar(body.material.model))
    return 3 * nodes;
  return 6 * nodes - 3 * body.edges.size();
}

Status SceneCompiler::compile_bodies() {
  if (m_shot.bodies.empty())
    return make_error(ErrorCode::bad_input, "{}: there is no [[body]], so there is nothing to simulate", m_shot.file);
  for (const shots::Body& body : m_shot.bodies) {
    if (m_shot.is_particles(body))
      continue;
    const shots::Material& material = *m_shot.find_material(*body.material);
    const bool plate = *material.model == shots::MaterialModel::plate;
    Result<MeshedBody> meshed =
        mesh_body_shared(m_shot, body, plate ? Filling::nothing : Filling::tets, m_options.shared);
    if (!meshed)
      return meshed.error();
    fem::FemBody compiled;
    compiled.name = *body.name;
    compiled.mesh = meshed->mesh;
    compiled.material = compile_material(material);
    const MicrorotationChoice choice = choose_microrotations(m_shot, body, material);
    if (choice.condensed)
      compiled.material.model = fem::ElasticModel::corotated;
    if (!choice.warning.empty())
      m_plan.warnings.push_back(choice.warning);
    if (shots::is_micropolar(*material.model))
      (choice.condensed ? m_plan.left_out : m_plan.runs)
          .push_back({"microrotations of " + *body.name, (choice.condensed ? "condensed: " : "") + choice.why});
    compiled.initial_velocity = *body.velocity;
    set_elements(body, material, *meshed, compiled);
    Result<fem::RestCurvature> rest_curvature =
        compile_rest_curvature(material, meshed->mesh, m_plan.sim.time_of(m_plan.sim.last_frame));
    if (!rest_curvature)
      return rest_curvature.error();
    compiled.rest_curvature = std::move(*rest_curvature);
    compiled.rest_curvature_moves = rest_curvature_moves(material);
    Result<fem::MaterialFactors> factors = compile_factors(material, *meshed->mesh);
    if (!factors)
      return factors.error();
    compiled.factors = std::move(*factors);
    if (Status status = compile_rest_rotation(body, compiled); !status)
      return status;
    BodyReport& report = meshed->report;
    report.model = describe_material(compiled.material);
    report.dofs = count_unknowns(compiled);
    report.model += describe_elements(compiled);
    if (plate)
      report.volume = compiled.thickness * area_of(*compiled.mesh, compiled.triangles);
    for (std::string& warning : element_warnings(compiled, report))
      m_plan.warnings.push_back(std::move(warning));
    report.mass = report.volume * compiled.material.density;
    m_plan.bodies.push_back(std::move(report));
    m_plan.body_looks.push_back(body.look ? **body.look : std::string());
    m_plan.assets.insert(m_plan.assets.end(), meshed->assets.begin(), meshed->assets.end());
    m_plan.sim.fem.bodies.push_back(std::move(compiled));
  }
  return {};
}

/// After the solids: that is the order in frames.
Status SceneCompiler::compile_particle_bodies() {
  const bool any = std::any_of(m_shot.bodies.begin(), m_shot.bodies.end(),
                               [&](const shots::Body& body) { return m_shot.is_particles(body); });
  if (!any)
    return {};
  mpm::MpmPlan& mpm = m_plan.sim.mpm;
  const Result<mpm::MpmSettings> settings = compile_mpm_settings(m_shot);
  if (!settings)
    return settings.error();
  mpm.settings = *settings;
  mpm.gravity = *m_shot.shot.gravity;
  for (const shots::Body& body : m_shot.bodies) {
    if (!m_shot.is_particles(body))
      continue;
    Result<CompiledParticles> compiled = compile_particles(m_shot, body, mpm.settings);
    if (!compiled)
      return compiled.error();
    if (compiled->source) {
      compiled->source->body = static_cast<int>(mpm.bodies.size());
      mpm.sources.push_back(*compiled->source);
    }
    m_plan.bodies.push_back(std::move(compiled->report));
    m_plan.body_looks.push_back(body.look ? **body.look : std::string());
    m_plan.assets.insert(m_plan.assets.end(), compiled->assets.begin(), compiled->assets.end());
    m_grain_assets.insert(m_grain_assets.end(), compiled->grain_assets.begin(), compiled->grain_assets.end());
    m_plan.warnings.insert(m_plan.warnings.end(), compiled->warnings.begin(), compiled->warnings.end());
    mpm.bodies.push_back(std::move(compiled->body));
  }
  for (std::string& warning : overlapping_bodies(m_shot, mpm))
    m_plan.warnings.push_back(std::move(warning));
  return {};
}

Status SceneCompiler::compile_fixed() {
  for (const shots::Fixed& fixed : m_shot.fixed) {
    if (m_shot.is_particles(*m_shot.find_body(*fixed.body))) {
      Result<mpm::HeldSpace> held = compile_held_space(fixed);
      if (!held)
        return held.error();
      m_plan.sim.mpm.held.push_back(std::move(*held));
      continue;
    }
    fem::FixedNodes nodes;
    nodes.name = *fixed.name;
    nodes.body = static_cast<int>(m_plan.sim.body_index(*fixed.body));
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
    Result<CompiledCollider> compiled = compile_collider(asked, m_shot.shot);
    if (!compiled)
      return compiled.error();
    const scene::Collider& collider = *compiled->collider;
    const auto* plane = std::get_if<scene::PlaneObstacle>(&collider.shape);
    if (plane != nullptr && !collider.motion.moves())
      m_plan.sim.fem.planes.push_back({collider.name, collider.motion.pose(0.0).apply(plane->point),
                                       collider.motion.pose(0.0).rotation * plane->normal, collider.friction});
    else if (plane == nullptr)
      m_plan.sim.fem.obstacles.push_back(collider);
    else if (!m_plan.sim.fem.bodies.empty())
      return at_source(asked.source,
                       make_error(ErrorCode::unavailable,
                                  "solids only know planes that stand still; take a box collider that moves"));
    m_plan.assets.insert(m_plan.assets.end(), compiled->assets.begin(), compiled->assets.end());
    if (!m_plan.sim.mpm.bodies.empty())
      m_plan.sim.mpm.colliders.push_back(compiled->collider);
    m_plan.sim.colliders.push_back(std::move(compiled->collider));
  }
  return {};
}

/// Where the vertices or particles of a body are at the start.
scene::RestPoints SceneCompiler::measured_points(std::size_t body) const {
  const std::size_t solids = m_plan.sim.fem.bodies.size();
  if (body < solids)
    return scene::rest_points(*m_plan.sim.fem.bodies[body].mesh);
  scene::RestPoints points;
  points.positions = *m_plan.sim.mpm.bodies[body - solids].positions;
  return points;
}

Status SceneCompiler::describe_measured_body(const shots::Measure& measure, MeasurePlan& compiled) const {
  const std::size_t solids = m_plan.sim.fem.bodies.size();
  const bool particles = compiled.body >= solids;
  const MeasuredOn on = measured_on(*measure.kind);
  if (on != MeasuredOn::both && (on == MeasuredOn::particles) != particles)
    return at_source(measure.source,
                     make_error(ErrorCode::bad_input, "this kind is measured on {} only, and body {} is made of {}",
                                particles ? "solids" : "particles", *measure.body, particles ? "particles" : "tets"));
  if (particles) {
    const mpm::MpmBody& body = m_plan.sim.mpm.bodies[compiled.body - solids];
    compiled.density = body.material.density;
    compiled.cell = m_plan.sim.mpm.settings.cell;
    compiled.particle_mass = body.material.density * body.particle_volume;
    compiled.start_low = body.positions->colwise().minCoeff();
    compiled.start_high = body.positions->colwise().maxCoeff();
    // Half a spacing beyond the outermost particles is where the matter ends.
    const double half = 0.5 * std::cbrt(body.particle_volume);
    compiled.start_low.array() -= half;
    compiled.start_high.array() += half;
  } else {
    compiled.density = m_plan.sim.fem.bodies[compiled.body].material.density;
  }
  compiled.up = m_plan.sim.up;
  return {};
}

Status SceneCompiler::compile_drives() {
  fem::FemPlan& plan = m_plan.sim.fem;
  for (const shots::Drive& drive : m_shot.drives) {
    if (m_shot.is_particles(*m_shot.find_body(*drive.body))) {
      Result<mpm::HeldSpace> driven = compile_driven_space(drive, m_plan.sim.colliders);
      if (!driven)
        return driven.error();
      m_plan.sim.mpm.held.push_back(std::move(*driven));
      continue;
    }
    const std::size_t body = m_plan.sim.body_index(*drive.body);
    Result<fem::DrivenNodes> compiled =
        compile_drive(drive, static_cast<int>(body), *plan.bodies[body].mesh, m_plan.sim.colliders);
    if (!compiled)
      return compiled.error();
    plan.driven.push_back(std::move(*compiled));
  }
  for (const shots::Load& load : m_shot.loads) {
    const std::size_t body = m_plan.sim.body_index(*load.body);
    Result<fem::FemLoad> compiled = compile_load(load, static_cast<int>(body), *plan.bodies[body].mesh);
    if (!compiled)
      return compiled.error();
    plan.loads.push_back(std::move(*compiled));
  }
  return {};
}

/// What frames must hold so that a measure can be taken.
void need_channels(const MeasurePlan& measure, fem::FemOutputs& outputs) {
  using Kind = shots::MeasureKind;
  outputs.reactions =
      outputs.reactions || measure.kind == Kind::reaction_force || measure.kind == Kind::reaction_torque;
  outputs.curvature_energy = outputs.curvature_energy || measure.kind == Kind::curvature_energy;
  outputs.point_rotations =
      outputs.point_rotations || measure.kind == Kind::curvature_error ||
      (measure.kind == Kind::rotation_distance && measure.at == shots::MeasureAt::points) ||
      (measure.kind == Kind::rotation_interpolation_error && measure.rule == shots::PointRotations::velocity);
}

Status SceneCompiler::compile_measures() {
  std::shared_ptr<const DrawnColliders> drawn_colliders;
  for (const shots::Measure& measure : m_shot.measures) {
    MeasurePlan compiled;
    compiled.name = *measure.name;
    compiled.kind = *measure.kind;
    compiled.body = m_plan.sim.body_index(*measure.body);
    const bool along_flow = *measure.kind == shots::MeasureKind::mean_alignment && !measure.axis;
    compiled.direction = measure.axis ? axis_vector(**measure.axis) : along_flow ? Vec3(Vec3::Zero()) : m_plan.sim.up;
    if (measure.about)
      compiled.about = **measure.about;
    compiled.at = *measure.at;
    compiled.rule = *measure.rule;
    need_channels(compiled, m_plan.sim.fem.outputs);
    if (Status status = describe_measured_body(measure, compiled); !status)
      return status;
    if (*measure.kind == shots::MeasureKind::grains_inside || *measure.kind == shots::MeasureKind::grain_hover) {
      if (drawn_colliders == nullptr)
        drawn_colliders = std::make_shared<const DrawnColliders>(m_plan.sim.colliders);
      compiled.drawn_colliders = drawn_colliders;
    }
    const bool in_space =
        *measure.kind == shots::MeasureKind::fraction_outside || *measure.kind == shots::MeasureKind::pile_height;
    if (measure.where && in_space) {
      compiled.region = compile_region(*measure.where);
    } else if (measure.where) {
      const scene::RestPoints points = measured_points(compiled.body);
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

/// Whether a key is about grains alone. How often they are brought up to date is kept with what carries them.
bool is_about_grains(const std::string& key) {
  return key.starts_with("body.") && key.find(".sub_particles.") != std::string::npos && !key.ends_with(".travel");
}

std::string SceneCompiler::key_of(Inputs what) const {
  std::string inputs = fmt::format("{} {}\n", simulation_build(), isa_name(m_options.isa));
  for (const shots::FlatKey& key : shots::flatten(m_shot)) {
    if (key.effect == shots::Effect::simulation && (what == Inputs::all || !is_about_grains(key.key)))
      inputs += key.key + "=" + key.value + "\n";
  }
  const fem::FemOutputs& outputs = m_plan.sim.fem.outputs;
  inputs +=
      fmt::format("frames hold {:d}{:d}{:d}\n", outputs.reactions, outputs.point_rotations, outputs.curvature_energy);
  for (const Asset& asset : m_plan.assets)
    inputs += asset.sha256 + "\n";
  for (const Asset& asset : m_grain_assets)
    inputs += what == Inputs::all ? asset.sha256 + "\n" : std::string();
  return sha256_of_bytes(inputs);
}

} // namespace

Result<ScenePlan> compile_scene(const shots::Shot& shot, const PlanOptions& options) {
  return SceneCompiler(shot, options).compile();
}

} // namespace wry::pipeline
