#include "pipeline/plan/cost.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/mpm/grains/sub_particles.h"
#include "sim/mpm/mpm_simulation.h"

namespace wry::pipeline {

namespace {

// Measured on a core with AVX2 (bench_fem_solver, shots/bunny.toml): evaluation and assembly of one Newton iteration
// per tet, and how many iterations a step takes. What its linear system costs is the choice of the solver's to say.
constexpr double CLASSIC_SECONDS_PER_TET = 0.2e-6;
constexpr double MICROPOLAR_SECONDS_PER_TET = 0.6e-6;
constexpr double CURVATURE_SECONDS_PER_TET = 0.7e-6; // beside the former
constexpr double NEWTON_PER_STEP = 6.0;
constexpr double NEWTON_PER_STEP_IN_CONTACT = 9.0;
constexpr double NEWTON_PER_STEP_WITH_FRICTION = 15.0; // with both passes
constexpr double CONTACT_SECONDS_PER_TRIANGLE =
    0.5e-6; // of the surface and Newton iteration: search, and limit of the step
// The second matrix of a step: each element's share of it is projected.
constexpr double DAMPING_SECONDS_PER_TET = 13e-6;
// One more gradient in each step.
constexpr double REACTION_SECONDS_PER_TET = 0.1e-6, MICROPOLAR_REACTION_SECONDS_PER_TET = 0.3e-6;
// Element data, two matrices and the vectors, per tet.
constexpr std::uint64_t CLASSIC_BYTES_PER_TET = 1200;
constexpr std::uint64_t MICROPOLAR_BYTES_PER_TET = 4500;
constexpr std::uint64_t DAMPING_BYTES_PER_TET = 270, MICROPOLAR_DAMPING_BYTES_PER_TET = 1000;
constexpr std::uint64_t CONTACT_BYTES_PER_TRIANGLE = 6000;
// What sorting and the grid take of memory besides the channels of a particle.
constexpr std::uint64_t MPM_BYTES_PER_PARTICLE_BESIDES = 250;
// A step of one particle in single precision (bench_mpm_table1), and what it takes more.
constexpr double MPM_SECONDS_PER_PARTICLE_STEP = 1.4e-7;
constexpr double DOUBLE_PRECISION = 1.6, OWN_AXES = 1.3, REORIENTING = 1.3, NEAR_MESHES = 1.6;
// Nodes near a mesh are kept out of it by their distance to it: by the faces of as many cells as the matter fills,
// taken for a cube (shots/dump_truck.toml and sweep_truck.toml).
constexpr double MESH_SECONDS_PER_FACE = 2.5e-5;
// A semi-implicit step over an explicit one, and each of its iterations; how many it takes where a wave crosses one
// cell more (bench_mpm_semi_implicit).
constexpr double SEMI_IMPLICIT_STEP = 1.7, SEMI_IMPLICIT_ITERATION = 0.85, ITERATIONS_PER_CELL = 1.1;
// One update of one grain, and that of one that meets meshes as they are drawn.
constexpr double SECONDS_PER_GRAIN = 0.8e-7, SECONDS_PER_GRAIN_NEAR_MESHES = 1.5e-7, TURNED_BY_FLOW = 1.35;
// A frame or checkpoint is checked, compressed by nothing, written and read again by measures.
constexpr double SECONDS_PER_BYTE_WRITTEN = 1e-8;
constexpr std::uint64_t FRAME_BYTES_PER_BODY = 4000; // what HDF5 writes besides values
// The program with its libraries; and a frame on its way out and back to be measured, in doubles and as bytes.
constexpr std::uint64_t PROGRAM_BYTES = 66'000'000;
constexpr std::uint64_t FRAMES_IN_MEMORY = 10;

bool meets_meshes(const mpm::MpmPlan& plan) {
  return std::any_of(plan.colliders.begin(), plan.colliders.end(),
                     [](const auto& collider) { return std::holds_alternative<scene::MeshObstacle>(collider->shape); });
}

/// Rows of a body's channels on vertices: quadratic elements have nodes at the middles of edges too.
std::uint64_t vertices_in_frame(const fem::FemBody& body) {
  return static_cast<std::uint64_t>(body.mesh->vertices.rows());
}

bool has_rotations(const fem::FemBody& body) {
  return fem::is_micropolar(body.material.model) || fem::is_plate(body.element);
}

std::uint64_t frame_bytes_of_solid(const fem::FemPlan& plan, const fem::FemBody& body, const BodyReport& report) {
  const bool micropolar = has_rotations(body);
  std::uint64_t per_node = 24 + 12, per_tet = 4; // position, velocity; energy density
  if (micropolar)
    per_node += (plan.outputs.point_rotations ? 32 : 16) + 12; // microrotation, angular velocity
  if (micropolar && plan.outputs.point_rotations)
    per_tet += 128;
  if (plan.outputs.reactions)
    per_node += 48;
  if (plan.outputs.curvature_energy)
    per_tet += 4;
  return FRAME_BYTES_PER_BODY + vertices_in_frame(body) * per_node + report.tets * per_tet;
}

/// Cells that the matter of particles fills.
double filled_cells(const mpm::MpmPlan& plan) {
  const double cell = plan.settings.cell * plan.settings.cell * plan.settings.cell;
  double cells = 0.0;
  for (const mpm::MpmBody& body : plan.bodies)
    cells += static_cast<double>(body.positions->rows()) * body.particle_volume / cell;
  return cells;
}

/// Bytes of a frame, in all frames.
std::uint64_t in_frames(double frames, std::uint64_t bytes_per_frame) {
  return static_cast<std::uint64_t>(frames * static_cast<double>(bytes_per_frame));
}

/// How a solid is told to have fewer elements.
std::string coarser(const shots::Shot& shot, const std::string& name) {
  for (const shots::Body& body : shot.bodies) {
    if (*body.name != name)
      continue;
    if (body.cells)
      return fmt::format("fewer body.{}.cells ({}) need less", name, body.cells->source.text());
    if (body.resolution)
      return fmt::format("a longer body.{}.resolution ({}) needs less", name, body.resolution->source.text());
  }
  return fmt::format("a coarser body.{}.mesh needs less", name);
}

/// How fast the fastest matter is on average, roughly: of what falls through its own height and comes to rest, or of
/// what goes on sliding for all of the shot.
double speed_of_fall(const SimPlan& plan, const BodyReport& report) {
  const Vec3& down = plan.mpm.gravity;
  const double gravity = down.norm();
  const double height = gravity > 0.0 ? report.size.dot(down.cwiseAbs()) / gravity : 0.0;
  return std::max(0.6 * std::sqrt(2.0 * gravity * height), 0.15 * gravity * plan.time_of(plan.last_frame));
}

/// Newton iterations of a step.
double newton_per_step(const fem::FemPlan& fem) {
  const auto rubs = [](const auto& collider) { return collider.friction > 0.0; };
  const bool touches = fem.contact || !fem.planes.empty() || !fem.obstacles.empty();
  const bool friction = std::any_of(fem.planes.begin(), fem.planes.end(), rubs) ||
                        std::any_of(fem.obstacles.begin(), fem.obstacles.end(), rubs) ||
                        (fem.contact && (fem.contact->friction.at_rest > 0.0 || !fem.contact->pairs.empty()));
  const double iterations = friction  ? NEWTON_PER_STEP_WITH_FRICTION
                            : touches ? NEWTON_PER_STEP_IN_CONTACT
                                      : NEWTON_PER_STEP;
  return iterations * (fem.settings.integrator == fem::Integrator::sdirk2 ? 2.0 : 1.0);
}

/// What a body of particles adds in `steps` steps of dt; returns the seconds of one of them.
double add_body_of_particles(const SimPlan& plan, const mpm::MpmBody& body, const BodyReport& report, double dt,
                             double steps, CostEstimate& cost) {
  const mpm::MpmPlan& mpm = plan.mpm;
  const bool double_precision = mpm.settings.precision == mpm::Precision::f64;
  const Result<mpm::CompiledMaterial> material = mpm::compile_material(body.material);
  const auto carries = [&](mpm::Channel channel) {
    return material &&
           std::find(material->channels.begin(), material->channels.end(), channel) != material->channels.end();
  };
  const bool own_axes = carries(mpm::Channel::frame);
  const bool near_meshes = meets_meshes(mpm);
  const double frames = plan.last_frame - plan.first_frame + 1;
  CostShare particles{fmt::format("the {} particles of body {}", report.particles, report.name),
                      fmt::format("a larger mpm.cell_size or fewer body.{}.particles_per_cell need less", report.name)};
  const std::uint64_t frame_bytes = FRAME_BYTES_PER_BODY + report.particles * (24 + 12 + 4 + (own_axes ? 16 : 0) +
                                                                               (body.material.reorientation ? 24 : 0));
  particles.memory_bytes = report.particles * (2 * report.bytes_per_particle + MPM_BYTES_PER_PARTICLE_BESIDES);
  particles.disk_bytes = in_frames(frames, frame_bytes);
  cost.memory_bytes += particles.memory_bytes;
  cost.bytes_per_frame += frame_bytes;
  cost.shares.push_back(std::move(particles));
  cost.bytes_per_checkpoint += report.particles * report.bytes_per_particle * (double_precision ? 1 : 2);
  double per_particle = MPM_SECONDS_PER_PARTICLE_STEP * (double_precision ? DOUBLE_PRECISION : 1.0) *
                        (own_axes ? OWN_AXES : 1.0) * (body.material.reorientation ? REORIENTING : 1.0) *
                        (near_meshes ? NEAR_MESHES : 1.0);
  if (mpm.settings.semi_implicit)
    per_particle *=
        SEMI_IMPLICIT_STEP + SEMI_IMPLICIT_ITERATION * ITERATIONS_PER_CELL * mpm.settings.semi_implicit->courant;
  if (body.sub_particles) {
    const auto per_body = static_cast<std::uint64_t>(body.sub_particles->per_particle);
    const double travel = body.sub_particles->travel * mpm.settings.cell;
    const double going = dt * std::max(speed_of_fall(plan, report), body.initial_velocity.norm());
    const double updates = travel > 0.0 ? std::clamp(going / travel, 0.02, 1.0) : 1.0;
    const double per_grain = (near_meshes ? SECONDS_PER_GRAIN_NEAR_MESHES : SECONDS_PER_GRAIN) *
                             (body.sub_particles->jeffery ? TURNED_BY_FLOW : 1.0);
    per_particle += static_cast<double>(per_body) * updates * per_grain;
    const std::uint64_t count = report.particles * per_body;
    CostShare grains{fmt::format("the {} grains of body {}", count, report.name),
                     fmt::format("fewer body.{}.sub_particles.per_particle need less", report.name)};
    grains.memory_bytes = count * 200;
    grains.disk_bytes = in_frames(frames, FRAME_BYTES_PER_BODY + count * mpm::BYTES_PER_GRAIN_AND_FRAME);
    cost.memory_bytes += grains.memory_bytes;
    cost.bytes_per_frame += FRAME_BYTES_PER_BODY + count * mpm::BYTES_PER_GRAIN_AND_FRAME;
    cost.bytes_per_checkpoint += count * 150;
    cost.shares.push_back(std::move(grains));
    if (mpm.settings.keep_fields)
      cost.field_bytes = std::max(cost.field_bytes,
                                  static_cast<std::uint64_t>(std::max(updates * steps, frames) * bytes_of_fields(mpm)));
  }
  return static_cast<double>(report.particles) * per_particle;
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
  for (const mpm::MpmBody& body : mpm.bodies) {
    const Result<mpm::CompiledMaterial> material = mpm::compile_material(body.material);
    facts.sound_speed = std::max(facts.sound_speed, material ? material->sound_speed : 0.0);
    facts.speed = std::max(facts.speed, body.initial_velocity.norm());
  }
  const mpm::StepBound bound = mpm::stable_step(facts);
  const double dt = mpm.settings.time_step ? std::min(*mpm.settings.time_step, bound.dt) : bound.dt;
  const double steps = std::ceil(plan.sim.time_of(plan.sim.last_frame) / dt);
  double seconds = cost.steps * cost.seconds_per_step;
  for (std::size_t i = 0; i < mpm.bodies.size(); ++i)
    seconds += steps * add_body_of_particles(plan.sim, mpm.bodies[i], plan.bodies[plan.sim.fem.bodies.size() + i], dt,
                                             steps, cost);
  if (meets_meshes(mpm))
    seconds += steps * MESH_SECONDS_PER_FACE * std::pow(filled_cells(mpm), 2.0 / 3.0);
  cost.steps = std::max(cost.steps, steps);
  cost.time_step = cost.time_step > 0.0 ? std::min(cost.time_step, dt) : dt;
  cost.seconds_per_step = cost.steps > 0.0 ? seconds / cost.steps : 0.0;
}

void add_cost_of_solids(const shots::Shot& shot, const ScenePlan& plan, CostEstimate& cost) {
  const fem::FemPlan& fem = plan.sim.fem;
  if (fem.bodies.empty())
    return;
  double seconds_per_iteration = 0.0, seconds_of_step = 0.0;
  const bool meets_surfaces = !fem.obstacles.empty() || (fem.contact && fem.contact->between_bodies) ||
                              (fem.contact && fem.contact->within_bodies);
  for (std::size_t i = 0; i < fem.bodies.size(); ++i) {
    const BodyReport& body = plan.bodies[i];
    const bool micropolar = has_rotations(fem.bodies[i]);
    CostShare elements{fmt::format("the {} elements of body {}", body.tets, body.name), coarser(shot, body.name)};
    const std::uint64_t frame_bytes = frame_bytes_of_solid(fem, fem.bodies[i], body);
    elements.memory_bytes = body.tets * (micropolar ? MICROPOLAR_BYTES_PER_TET : CLASSIC_BYTES_PER_TET);
    elements.disk_bytes = in_frames(plan.sim.last_frame - plan.sim.first_frame + 1, frame_bytes);
    const bool damped = fem.bodies[i].material.stiffness_damping > 0.0;
    if (damped)
      elements.memory_bytes += body.tets * (micropolar ? MICROPOLAR_DAMPING_BYTES_PER_TET : DAMPING_BYTES_PER_TET);
    if (meets_surfaces)
      elements.memory_bytes += body.surface_triangles * CONTACT_BYTES_PER_TRIANGLE;
    cost.memory_bytes += elements.memory_bytes;
    cost.bytes_per_frame += frame_bytes;
    cost.shares.push_back(std::move(elements));
    cost.bytes_per_checkpoint +=
        vertices_in_frame(fem.bodies[i]) * (micropolar ? 128 : 48) + (micropolar ? body.tets * 128 : 0);
    const bool curved = fem.bodies[i].material.curvature != fem::CurvatureModel::none;
    seconds_per_iteration +=
        static_cast<double>(body.tets) * ((micropolar ? MICROPOLAR_SECONDS_PER_TET : CLASSIC_SECONDS_PER_TET) +
                                          (curved ? CURVATURE_SECONDS_PER_TET : 0.0));
    if (meets_surfaces)
      seconds_per_iteration += static_cast<double>(body.surface_triangles) * CONTACT_SECONDS_PER_TRIANGLE;
    if (damped)
      seconds_of_step += static_cast<double>(body.tets) * DAMPING_SECONDS_PER_TET;
    if (fem.outputs.reactions)
      seconds_of_step += static_cast<double>(body.tets) *
                         (micropolar ? MICROPOLAR_REACTION_SECONDS_PER_TET : REACTION_SECONDS_PER_TET);
  }
  const double per_step = newton_per_step(fem);
  cost.seconds_per_step = per_step * seconds_per_iteration + seconds_of_step;
  cost.time_step = fem.settings.max_time_step;
  cost.steps = plan.sim.time_of(plan.sim.last_frame) / cost.time_step;
  cost.newton_directions = per_step * cost.steps;
}

} // namespace

double bytes_of_fields(const mpm::MpmPlan& plan) {
  // Nodes about the matter, 16 bytes each and some for blocks.
  constexpr double NODES_PER_CELL = 2.0, BYTES_PER_NODE = 17.0;
  return NODES_PER_CELL * BYTES_PER_NODE * filled_cells(plan);
}

CostEstimate estimate_cost(const shots::Shot& shot, const ScenePlan& plan) {
  CostEstimate cost;
  add_cost_of_solids(shot, plan, cost);
  add_cost_of_particles(plan, cost);
  cost.memory_bytes += PROGRAM_BYTES + FRAMES_IN_MEMORY * cost.bytes_per_frame;
  const double frames = plan.sim.last_frame - plan.sim.first_frame + 1;
  const double every = static_cast<double>(*shot.fem.checkpoint_every);
  cost.checkpoints_kept = static_cast<double>(*shot.fem.keep) + (every > 0.0 ? std::floor(frames / every) : 0.0);
  cost.shares.push_back({fmt::format("{:.0f} checkpoints", cost.checkpoints_kept),
                         "a smaller fem.keep and a larger fem.checkpoint_every (0: none) need less", 0,
                         in_frames(cost.checkpoints_kept, cost.bytes_per_checkpoint)});
  if (cost.field_bytes > 0)
    cost.shares.push_back({"the fields that carry grains", "mpm.keep_fields = false needs none", 0, cost.field_bytes});
  if (cost.steps > 0.0)
    cost.seconds_per_step += SECONDS_PER_BYTE_WRITTEN * frames *
                             static_cast<double>(cost.bytes_per_frame + cost.bytes_per_checkpoint) / cost.steps;
  return cost;
}

namespace {

std::string describe_tolerance(const fem::FemSimulation& simulation, const fem::FemSettings& settings) {
  const double own = simulation.newton_tolerance(settings.max_time_step);
  std::string words = fmt::format("until {:.3g} N s are out of balance", own);
  if (own < settings.newton_tolerance)
    words += fmt::format(": fem.newton_tolerance = {:.3g} is too much for bodies so light", settings.newton_tolerance);
  return words;
}

} // namespace

Status describe_solver(ScenePlan& plan, Isa isa, int threads) {
  if (plan.sim.fem.bodies.empty())
    return {};
  const Result<std::unique_ptr<fem::FemSimulation>> simulation = fem::FemSimulation::create(plan.sim.fem, threads, isa);
  if (!simulation)
    return simulation.error();
  const fem::SolverChoice choice = (*simulation)->solver_choice();
  plan.runs.push_back({"Newton's method", describe_tolerance(**simulation, plan.sim.fem.settings)});
  plan.runs.push_back({"linear solver", choice.reason});
  plan.cost.seconds_of_directions = plan.cost.newton_directions * choice.seconds_per_direction;
  add_cost_of_solver(plan.cost, **simulation);
  return {};
}

void add_cost_of_solver(CostEstimate& cost, const fem::FemSimulation& built) {
  if (const std::uint64_t kept = built.solver_bytes_in_checkpoint(); kept > 0) {
    cost.bytes_per_checkpoint += kept;
    cost.shares.push_back({fmt::format("the matrix of a factor in {:.0f} checkpoints", cost.checkpoints_kept),
                           "a smaller fem.keep needs less, and fem.linear_solver = \"pcg\" has no factors", 0,
                           in_frames(cost.checkpoints_kept, kept)});
  }
  const std::uint64_t memory = built.memory_bytes();
  if (PROGRAM_BYTES + memory <= cost.memory_bytes)
    return;
  cost.memory_bytes = PROGRAM_BYTES + memory;
  cost.shares.push_back({"matrices, factors and elements",
                         cost.shares.front().cure + ", and fem.linear_solver = \"pcg\" has no factors", memory, 0});
}

} // namespace wry::pipeline
