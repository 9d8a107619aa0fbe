#include "sim/fem/fem_simulation.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include "sim/fem/boundary.h"
#include "sim/fem/contact_system.h"
#include "sim/fem/fem_scene.h"
#include "sim/fem/fem_state.h"
#include "sim/fem/first_guess.h"
#include "sim/fem/newton.h"
#include "sim/fem/nodal_rotations.h"
#include "sim/fem/reactions.h"
#include "sim/fem/solver_choice.h"
#include "sim/fem/state_report.h"
#include "sim/fem/step_control.h"
#include "sim/fem/terms/node_terms.h"
#include "sim/fem/terms/stiffness_damping.h"
#include "sim/fem/time_integrator.h"

namespace wry::fem {

namespace {

/// Friction follows the normal forces in three passes. The first finds them roughly, to this share of the residual it
/// begins with. The second to this share of the momentum that friction gives the nodes: a momentum which is out of
/// balance by so much can be missing in the normal forces, so friction is off by at most mu times that share in the
/// last pass, which is solved to the tolerance.
constexpr double ROUGH_SHARE = 0.02;
constexpr double FRICTION_SHARE = 0.05;
enum class FrictionPass { rough, near, last };
/// A body that comes nearer than this share of d-hat gets a stiffer barrier for the steps to come.
constexpr double CROWDED_SHARE = 0.02;
constexpr double STIFFEN_BY = 4.0;
/// A step that was cut so often goes on with contacts as stiff as before it.
constexpr int CUTS_WITH_STIFFER = 9;

class Simulation final : public FemSimulation {
public:
  Simulation(FemPlan plan, int threads, Isa isa)
      : m_plan(std::move(plan))
      , m_threads(threads)
      , m_isa(isa)
      , m_control(m_plan.settings.max_time_step, std::min(m_plan.settings.min_time_step, m_plan.settings.max_time_step))
      , m_integrator(m_plan.settings.integrator) {}

  Status initialise();

  Result<StepStats> step(double end) override;
  double time() const override { return m_state.time; }
  SceneStatic scene_static() const override;
  Frame snapshot(int number) const override;
  StateArchive archive() const override;
  Status restore(const StateArchive& archive) override;
  SolverChoice solver_choice() const override { return m_linear.choice; }
  double newton_tolerance(double dt) const override;
  std::size_t dof_count() const override { return m_scene.model.layout.dof_count(); }
  std::size_t memory_bytes() const override;
  std::size_t solver_bytes_in_checkpoint() const override { return m_linear.method->saved_bytes(); }

private:
  void make_terms();
  void hold_nodes(double time);
  void turn_ahead(const Points& increments);
  double friction_momentum(const Stage& stage, const Trial& trial) const;
  NewtonReport attempt(double dt, double end);
  NewtonReport solve(const PlannedStage& planned, Trial& trial);
  void accept(const Stage& stage, const Trial& trial);
  void stiffen_crowded_contacts();
  Error give_up(double dt, const NewtonReport& report) const;

  FemPlan m_plan;
  Threads m_threads;
  Isa m_isa;
  FemScene m_scene;
  ContactState m_contact;
  std::unique_ptr<ContactSystem> m_contact_system;
  std::unique_ptr<BlockMatrix> m_matrix;
  ChosenMethod m_linear;
  std::vector<std::unique_ptr<EnergyTerm>> m_node_terms;
  std::vector<EnergyTerm*> m_terms;
  Boundary m_boundary;
  std::vector<Mat3> m_node_rotations;
  std::vector<const EnergyTerm*> m_friction;
  FemState m_state;
  StepControl m_control;
  TimeIntegrator m_integrator;
  Reactions m_reactions;
  int m_steps_since_reset = 0;
};

Status Simulation::initialise() {
  Result<FemScene> scene = build_scene(m_plan, m_isa, m_threads);
  if (!scene)
    return std::move(scene).error();
  m_scene = std::move(scene).value();
  m_contact.distance = m_plan.settings.contact_distance.value_or(m_scene.suggested_contact_distance);
  m_contact.stiffness = choose_contact_stiffness(m_plan, m_scene, m_contact.distance);
  m_boundary = Boundary(m_plan, m_scene);
  hold_nodes(0.0);
  if (Status status = clear_planes(m_plan, m_contact, m_scene); !status)
    return status;
  Result<std::unique_ptr<ContactSystem>> system =
      ContactSystem::create(m_plan, m_scene, m_contact.distance, m_threads, m_isa);
  if (!system)
    return std::move(system).error();
  m_contact_system = std::move(system).value();
  m_contact.system = m_contact_system.get();
  m_scene.model.springs = make_drive_springs(m_plan, m_scene);
  m_scene.model.rotations = &m_state.rotations;
  std::vector<std::array<std::int32_t, 4>> tets;
  for (const std::unique_ptr<BodyElements>& elements : m_scene.elements) {
    const std::vector<std::array<std::int32_t, 4>> nodes = elements->node_quadruples();
    tets.insert(tets.end(), nodes.begin(), nodes.end());
  }
  m_matrix = std::make_unique<BlockMatrix>(m_scene.model.layout, tets, m_isa);
  std::vector<DampedElements> damped;
  for (std::size_t body = 0; body < m_plan.bodies.size(); ++body) {
    if (const double damping = m_plan.bodies[body].material.stiffness_damping; damping > 0.0)
      damped.push_back({m_scene.elements[body].get(), damping});
  }
  if (!damped.empty())
    m_node_terms.push_back(make_stiffness_damping(
        m_scene.model, std::move(damped), std::make_unique<BlockMatrix>(m_scene.model.layout, tets, m_isa), m_threads));
  Result<ChosenMethod> method = choose_linear_method(m_plan, m_scene, *m_matrix, m_threads);
  if (!method)
    return std::move(method).error();
  m_linear = std::move(method).value();
  m_state = initial_state(m_plan, m_scene);
  make_terms();
  return {};
}

void Simulation::make_terms() {
  for (const std::unique_ptr<EnergyTerm>& term : m_node_terms)
    m_terms.push_back(term.get());
  for (const EnergyTermEntry& entry : energy_term_table()) {
    std::unique_ptr<EnergyTerm> term = entry.make(m_scene.model, m_contact);
    if (!term)
      continue;
    if (entry.name == "plane_friction" || entry.name == "pair_friction")
      m_friction.push_back(term.get());
    m_terms.push_back(term.get());
    m_node_terms.push_back(std::move(term));
  }
  for (const std::unique_ptr<BodyElements>& elements : m_scene.elements) {
    elements->bind_model(m_scene.model, *m_matrix);
    elements->bind_rotations(&m_state.rotations);
    elements->update_rest_curvature(m_state.time);
    m_terms.push_back(elements.get());
  }
}

/// Marks the unknowns that are given in a step which ends at `time`, and the nodes that obstacles cannot push.
void Simulation::hold_nodes(double time) {
  m_boundary.hold(time);
  m_contact.ignored = m_boundary.immovable();
}

double Simulation::newton_tolerance(double dt) const {
  const Vec3 extent = m_scene.start_positions.colwise().maxCoeff() - m_scene.start_positions.colwise().minCoeff();
  const double speed = std::max(1e-3 * m_plan.gravity.norm() * dt, 1e-5 * extent.norm() / dt);
  double squares = 0.0;
  for (const double mass : m_scene.model.mass)
    squares += mass * mass;
  return std::min(m_plan.settings.newton_tolerance, std::sqrt(squares) * speed);
}

/// What friction gives the nodes in the step [N s].
double Simulation::friction_momentum(const Stage& stage, const Trial& trial) const {
  std::vector<double> momentum(m_scene.model.layout.dof_count(), 0.0);
  for (const EnergyTerm* term : m_friction)
    term->add_gradient(stage, trial, momentum);
  return Eigen::Map<const Eigen::VectorXd>(momentum.data(), static_cast<Eigen::Index>(momentum.size())).norm();
}

/// Turns the stored rotations of nodes and quadrature points.
void Simulation::turn_ahead(const Points& increments) {
  Trial turn;
  turn.increments = increments;
  for (const std::unique_ptr<BodyElements>& elements : m_scene.elements)
    elements->advance_rotations(turn);
  for (Eigen::Index node = 0; node < increments.rows(); ++node)
    m_state.rotations.row(node) = turned(m_state.rotations.row(node), increments.row(node));
  place_midpoint_rotations(m_scene.model, m_state.rotations);
}

NewtonReport Simulation::solve(const PlannedStage& planned, Trial& trial) {
  const Stage& stage = planned.stage;
  const NewtonSettings settings{newton_tolerance(stage.dt), m_plan.settings.max_newton_iterations,
                                m_plan.settings.linear_tolerance};
  NewtonProblem problem{m_scene.model,
                        m_terms,
                        m_boundary.held(),
                        *m_matrix,
                        *m_linear.method,
                        m_threads,
                        [this](const Trial& at) -> const std::vector<Mat3>& {
                          estimate_node_rotations(m_scene, m_state.rotations, at, m_node_rotations);
                          return m_node_rotations;
                        }};
  Trial start;
  start.velocities = planned.guess_velocities;
  start.angular = planned.guess_angular;
  update_trial(stage, start);
  start.positions = m_state.positions;
  for (EnergyTerm* term : m_terms)
    term->begin_step(stage, m_state.positions);
  for (EnergyTerm* term : m_terms)
    term->begin_solve(stage, start);
  const FirstGuess guess = first_guess(planned, m_state, m_boundary, m_terms, !m_plan.driven.empty());
  trial = guess.trial;
  problem.given = guess.given ? &*guess.given : nullptr;
  if (m_friction.empty())
    return minimise(problem, settings, stage, trial);
  NewtonReport total;
  for (const FrictionPass pass : {FrictionPass::rough, FrictionPass::near, FrictionPass::last}) {
    NewtonSettings own = settings;
    if (pass == FrictionPass::rough)
      own.relative_tolerance = ROUGH_SHARE;
    if (pass == FrictionPass::near)
      own.tolerance = std::max(settings.tolerance, FRICTION_SHARE * friction_momentum(stage, trial));
    total = sum_of(total, minimise(problem, own, stage, trial));
    problem.given = nullptr;
    if (!total.converged || pass == FrictionPass::last)
      break;
    for (EnergyTerm* term : m_terms)
      term->begin_solve(stage, trial);
  }
  return total;
}

/// One step, stage by stage; the state changes only if it converges.
NewtonReport Simulation::attempt(double dt, double end) {
  const RotationHistory before =
      m_integrator.predicts() ? RotationHistory(m_state.rotations, m_scene.elements) : RotationHistory();
  NewtonReport total;
  Trial trial;
  for (int index = 0; index < m_integrator.stage_count(); ++index) {
    PlannedStage planned = m_integrator.plan(index, dt, end, m_state, trial);
    planned.stage.exponential = m_plan.settings.rotation_update == RotationUpdate::exponential;
    hold_nodes(planned.stage.time);
    if (index > 0)
      before.restore(m_state.rotations, m_scene.elements);
    if (planned.predictor.rows() > 0)
      turn_ahead(planned.predictor);
    total = sum_of(total, solve(planned, trial));
    if (!total.converged) {
      before.restore(m_state.rotations, m_scene.elements);
      return total;
    }
    if (index + 1 < m_integrator.stage_count())
      continue;
    m_integrator.remember(dt, m_state, planned, trial);
    if (m_plan.outputs.reactions)
      m_reactions = measure_reactions(m_scene.model, m_terms, m_boundary, planned.stage, trial);
    accept(planned.stage, trial);
  }
  return total;
}

Result<StepStats> Simulation::step(double end) {
  const auto start = std::chrono::steady_clock::now();
  StepStats stats;
  if (!(end > m_state.time))
    return make_error(ErrorCode::usage, "cannot step from {} s to {} s", m_state.time, end);
  if (m_contact_system)
    m_contact_system->take_cost(); // what was searched before is no part of the step
  NewtonReport total;
  std::vector<double> stiffness_before; ///< of contacts, once a step had to be cut
  for (;;) {
    // Steps end where a hold ends or a motion has a corner, and are short where a drive turns fast.
    const double event = m_boundary.next_event(m_state.time, end);
    const double longest = m_boundary.limit_step(m_state.time, m_control.current());
    const StepControl::Step next = m_control.next(m_state.time, event, longest);
    const NewtonReport report = attempt(next.dt, next.lands ? event : m_state.time + next.dt);
    total = sum_of(total, report);
    if (report.converged) {
      m_control.succeeded();
      stats.dt = next.dt;
      break;
    }
    ++stats.cuts;
    // A barrier that is too soft for the momentum that meets it makes Newton crawl. If the step does not get on with a
    // stiffer one either, that was not to blame.
    if (m_contact_system && !m_plan.settings.contact_stiffness) {
      if (stats.cuts == 1)
        stiffness_before = m_contact_system->stiffnesses();
      if (stats.cuts < CUTS_WITH_STIFFER)
        m_contact_system->stiffen_limiting(STIFFEN_BY);
      if (stats.cuts == CUTS_WITH_STIFFER)
        m_contact_system->stiffnesses() = stiffness_before;
    }
    if (!m_control.failed(next.dt))
      return give_up(next.dt, report);
  }
  stats.time = m_state.time;
  stats.newton_iterations = total.iterations;
  stats.linear_iterations = total.linear_iterations;
  stats.line_search_halvings = total.halvings;
  stats.projected_elements = total.projected_elements;
  stats.residual = total.residual;
  stats.evaluate_ms = total.evaluate_ms;
  stats.assemble_ms = total.assemble_ms;
  stats.solve_ms = total.solve_ms;
  const PlaneGaps gaps = measure_plane_gaps(m_scene.model, m_contact, m_state.positions, -1);
  stats.contacts = gaps.active;
  stats.least_distance = gaps.least;
  if (m_contact_system) {
    const ContactSystem::Gaps pairs = m_contact_system->measure(m_state.positions);
    stats.contacts += pairs.active;
    stats.least_distance = std::min(stats.least_distance, pairs.least);
  }
  stiffen_crowded_contacts();
  if (m_contact_system) {
    const ContactSystem::Cost cost = m_contact_system->take_cost();
    stats.contact_search_ms = cost.search_ms;
    stats.safe_step_ms = cost.safe_step_ms;
  }
  add_energies(m_scene, m_state, stats);
  stats.total_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return stats;
}

void Simulation::accept(const Stage& stage, const Trial& trial) {
  turn_ahead(trial.increments);
  m_state.positions = trial.positions;
  m_state.velocities = trial.velocities;
  m_state.angular = trial.angular;
  m_state.time = stage.time;
  const FemSettings& settings = m_plan.settings;
  if (settings.reset_every == 0 || settings.point_rotations == PointRotations::interpolated_velocity ||
      ++m_steps_since_reset < settings.reset_every)
    return;
  m_steps_since_reset = 0;
  for (const std::unique_ptr<BodyElements>& elements : m_scene.elements)
    elements->reset_point_rotations(settings.point_rotations);
}

void Simulation::stiffen_crowded_contacts() {
  if (m_plan.settings.contact_stiffness)
    return;
  if (m_contact_system)
    m_contact_system->stiffen_crowded(m_state.positions, CROWDED_SHARE, STIFFEN_BY);
  if (m_scene.model.planes.empty())
    return;
  for (std::size_t body = 0; body < m_contact.stiffness.size(); ++body) {
    const PlaneGaps gaps = measure_plane_gaps(m_scene.model, m_contact, m_state.positions, static_cast<int>(body));
    if (gaps.least < CROWDED_SHARE * m_contact.distance)
      m_contact.stiffness[body] *= STIFFEN_BY;
  }
}

Error Simulation::give_up(double dt, const NewtonReport& report) const {
  return make_error(
      ErrorCode::solver,
      "solids: no step from t = {:.6g} s: {} at dt = {:.3g} s (floor {:.3g} s): residual {:.3g} N s after {} "
      "iterations, tolerance {:.3g}, round-off about {:.3g}; the last good state is kept. Try a smaller "
      "fem.max_time_step, more fem.max_newton_iterations, a larger fem.newton_tolerance, or softer loads{}",
      m_state.time, report.trouble, dt, m_plan.settings.min_time_step, report.residual, report.iterations,
      m_plan.settings.newton_tolerance, report.round_off_floor,
      (m_contact_system && !m_contact_system->describe_limit().empty() ? "; " + m_contact_system->describe_limit()
                                                                       : "") +
          (report.trouble == ENERGY_NOT_FINITE ? describe_inverted(m_plan, m_scene, m_state) : ""));
}

SceneStatic Simulation::scene_static() const {
  return describe_bodies(m_plan);
}

Frame Simulation::snapshot(int number) const {
  const Trial trial = trial_at_rest_in(m_state);
  std::vector<std::vector<double>> energies;
  for (const std::unique_ptr<BodyElements>& elements : m_scene.elements)
    energies.push_back(elements->element_energies(trial));
  Frame frame = take_snapshot(m_plan, m_scene, m_state, energies, number);
  if (m_plan.outputs.curvature_energy) {
    for (std::size_t body = 0; body < energies.size(); ++body) {
      const std::vector<double> elastic = m_scene.elements[body]->elastic_energies(trial);
      for (std::size_t element = 0; element < elastic.size(); ++element)
        energies[body][element] -= elastic[element];
      add_energy_density("curvature_energy_density", m_scene, body, energies[body], frame);
    }
  }
  if (m_plan.outputs.reactions)
    add_reactions(m_scene, m_reactions.forces, m_reactions.torques, frame);
  return frame;
}

StateArchive Simulation::archive() const {
  StateArchive archive = archive_state(m_scene, m_state);
  archive.push_back({"fem/step_control", {2}, {m_control.current(), static_cast<double>(m_control.successes())}});
  archive.push_back({"fem/steps_since_reset", {1}, {static_cast<double>(m_steps_since_reset)}});
  archive.push_back({"fem/contact_stiffness", {m_contact.stiffness.size()}, m_contact.stiffness});
  if (m_contact_system)
    archive.push_back(
        {"fem/pair_stiffness", {m_contact_system->stiffnesses().size()}, m_contact_system->stiffnesses()});
  m_linear.method->save(archive);
  m_integrator.save(archive);
  return archive;
}

Status Simulation::restore(const StateArchive& archive) {
  FemState state = m_state;
  if (Status status = restore_state(archive, m_scene, state); !status)
    return status;
  const NamedArray* control = find_array(archive, "fem/step_control", 2);
  const NamedArray* stiffness = find_array(archive, "fem/contact_stiffness", m_contact.stiffness.size());
  const NamedArray* reset = find_array(archive, "fem/steps_since_reset", 1);
  if (control == nullptr || stiffness == nullptr || reset == nullptr)
    return make_error(ErrorCode::io, "checkpoint: fem/step_control, fem/contact_stiffness or fem/steps_since_reset is "
                                     "missing");
  if (Status status = m_linear.method->restore(archive); !status)
    return status;
  if (Status status = m_integrator.restore(archive, state); !status)
    return status;
  m_state = std::move(state);
  m_control.restore(control->values[0], static_cast<int>(control->values[1]));
  m_contact.stiffness = stiffness->values;
  if (m_contact_system) {
    const NamedArray* pairs = find_array(archive, "fem/pair_stiffness", m_contact_system->stiffnesses().size());
    if (pairs == nullptr)
      return make_error(ErrorCode::io, "checkpoint: fem/pair_stiffness is missing");
    m_contact_system->stiffnesses() = pairs->values;
    m_contact_system->place_obstacles(m_state.time);
  }
  m_steps_since_reset = static_cast<int>(reset->values[0]);
  hold_nodes(m_state.time);
  for (const std::unique_ptr<BodyElements>& elements : m_scene.elements)
    elements->update_rest_curvature(m_state.time);
  return {};
}

std::size_t Simulation::memory_bytes() const {
  std::size_t bytes = m_matrix->memory_bytes() + m_linear.method->memory_bytes();
  for (const std::unique_ptr<BodyElements>& elements : m_scene.elements)
    bytes += elements->memory_bytes();
  if (m_contact_system)
    bytes += m_contact_system->memory_bytes();
  return bytes + static_cast<std::size_t>(m_scene.model.layout.node_count()) * 60 * sizeof(double);
}

} // namespace

Result<std::unique_ptr<FemSimulation>> FemSimulation::create(FemPlan plan, int threads, Isa isa) {
  std::unique_ptr<Simulation> simulation = std::make_unique<Simulation>(std::move(plan), threads, isa);
  if (Status status = simulation->initialise(); !status)
    return status.error();
  return std::unique_ptr<FemSimulation>(std::move(simulation));
}

} // namespace wry::fem
