#include "sim/fem/fem_simulation.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "sim/fem/fem_scene.h"
#include "sim/fem/fem_state.h"
#include "sim/fem/newton.h"
#include "sim/fem/nodal_rotations.h"
#include "sim/fem/solver_choice.h"
#include "sim/fem/step_control.h"
#include "sim/fem/terms/node_terms.h"

namespace wry::fem {

namespace {

constexpr int FRICTION_PASSES = 2;
/// A body that comes nearer than this share of d-hat gets a stiffer barrier for the steps to come.
constexpr double CROWDED_SHARE = 0.02;
constexpr double STIFFEN_BY = 4.0;

class Simulation final : public FemSimulation {
public:
  Simulation(FemPlan plan, int threads, Isa isa)
      : m_plan(std::move(plan))
      , m_threads(threads)
      , m_isa(isa)
      , m_control(m_plan.settings.max_time_step,
                  std::min(m_plan.settings.min_time_step, m_plan.settings.max_time_step)) {}

  Status initialise();

  Result<StepStats> step(double end) override;
  double time() const override { return m_state.time; }
  SceneStatic scene_static() const override;
  Frame snapshot(int number) const override;
  StateArchive archive() const override;
  Status restore(const StateArchive& archive) override;
  SolverChoice solver_choice() const override { return m_linear.choice; }
  std::size_t dof_count() const override { return m_scene.model.layout.dof_count(); }
  std::size_t memory_bytes() const override;

private:
  void make_terms();
  void hold_nodes(double time);
  Stage backward_euler(double dt, double time) const;
  Trial first_guess(const Stage& stage) const;
  double tolerance(double dt) const;
  NewtonReport attempt(const Stage& stage, Trial& trial);
  void accept(const Stage& stage, const Trial& trial);
  void stiffen_crowded_contacts();
  void report_energies(const Trial& trial, StepStats& stats);
  Trial trial_at_rest_in_state() const;
  Error give_up(double dt, const NewtonReport& report) const;

  FemPlan m_plan;
  Threads m_threads;
  Isa m_isa;
  FemScene m_scene;
  ContactState m_contact;
  std::unique_ptr<BlockMatrix> m_matrix;
  ChosenMethod m_linear;
  std::vector<std::unique_ptr<EnergyTerm>> m_node_terms;
  std::vector<EnergyTerm*> m_terms;
  std::vector<char> m_held;
  std::vector<Mat3> m_node_rotations;
  bool m_friction = false;
  FemState m_state;
  StepControl m_control;
};

Status Simulation::initialise() {
  Result<FemScene> scene = build_scene(m_plan, m_isa, m_threads);
  if (!scene)
    return std::move(scene).error();
  m_scene = std::move(scene).value();
  m_contact.distance = m_plan.settings.contact_distance.value_or(m_scene.suggested_contact_distance);
  m_contact.stiffness = choose_contact_stiffness(m_plan, m_scene, m_contact.distance);
  hold_nodes(0.0);
  if (Status status = clear_planes(m_plan, m_contact, m_scene); !status)
    return status;
  std::vector<std::array<std::int32_t, 4>> tets;
  for (const std::unique_ptr<ElementTerm>& elements : m_scene.elements) {
    const std::vector<std::array<std::int32_t, 4>> nodes = elements->element_nodes();
    tets.insert(tets.end(), nodes.begin(), nodes.end());
  }
  m_matrix = std::make_unique<BlockMatrix>(m_scene.model.layout, tets, m_isa);
  Result<ChosenMethod> method = choose_linear_method(m_plan, m_scene, *m_matrix, m_threads);
  if (!method)
    return std::move(method).error();
  m_linear = std::move(method).value();
  m_state = initial_state(m_plan, m_scene);
  make_terms();
  return {};
}

void Simulation::make_terms() {
  for (const EnergyTermEntry& entry : energy_term_table()) {
    std::unique_ptr<EnergyTerm> term = entry.make(m_scene.model, m_contact);
    if (!term)
      continue;
    m_friction = m_friction || entry.name == "plane_friction";
    m_terms.push_back(term.get());
    m_node_terms.push_back(std::move(term));
  }
  for (const std::unique_ptr<ElementTerm>& elements : m_scene.elements) {
    elements->bind_layout(m_scene.model.layout, *m_matrix);
    elements->bind_rotations(&m_state.rotations);
    elements->update_rest_curvature(m_state.time);
    m_terms.push_back(elements.get());
  }
}

/// Marks the unknowns that are held in a step which ends at `time`, and the nodes that obstacles cannot push.
void Simulation::hold_nodes(double time) {
  const FemModel& model = m_scene.model;
  m_held.assign(model.layout.dof_count(), 0);
  m_contact.ignored.assign(model.layout.node_count(), 0);
  const auto hold = [&](int node, int first, int last) {
    for (int i = first; i < last; ++i)
      m_held[model.layout.dof(node) + i] = 1;
  };
  for (const FixedNodes& fixed : m_plan.fixed) {
    if (fixed.until && time > *fixed.until * (1.0 + 1e-12))
      continue;
    for (const std::int32_t vertex : fixed.nodes) {
      const int node = model.bodies[fixed.body].first_node + m_scene.meshes[fixed.body].node_of_vertex[vertex];
      if (fixed.hold_positions)
        hold(node, 0, 3);
      if (fixed.hold_microrotations && model.layout.dofs(node) == 6)
        hold(node, 3, 6);
    }
  }
  for (int node = 0; node < model.layout.node_count(); ++node) {
    if (model.mass[node] == 0.0) // in no tet: nothing moves it
      hold(node, 0, model.layout.dofs(node));
    m_contact.ignored[node] = m_held[model.layout.dof(node)];
  }
}

Stage Simulation::backward_euler(double dt, double time) const {
  Stage stage;
  stage.beta = stage.dt = dt;
  stage.time = time;
  stage.base_positions = stage.start_positions = m_state.positions;
  stage.base_velocities = m_state.velocities;
  stage.base_angular = m_state.angular;
  return stage;
}

/// Last velocities, shortened where they would pass an obstacle; zero where they would invert elements.
Trial Simulation::first_guess(const Stage& stage) const {
  Trial trial;
  trial.velocities = m_state.velocities;
  trial.angular = m_state.angular;
  for (int node = 0; node < m_scene.model.layout.node_count(); ++node) {
    const std::size_t dof = m_scene.model.layout.dof(node);
    if (m_held[dof])
      trial.velocities.row(node).setZero();
    if (m_scene.model.layout.dofs(node) == 6 && m_held[dof + 3])
      trial.angular.row(node).setZero();
  }
  Trial still = trial;
  still.velocities.setZero();
  still.angular.setZero();
  update_trial(stage, still);
  double limit = 1.0;
  const Points change = stage.beta * trial.velocities;
  for (const EnergyTerm* term : m_terms)
    limit = std::min(limit, term->step_limit(still, change));
  trial.velocities *= limit;
  update_trial(stage, trial);
  for (const EnergyTerm* term : m_terms) {
    if (!std::isfinite(term->energy(stage, trial)))
      return still;
  }
  return trial;
}

/// The plan's tolerance, which is a momentum, unless that is more than a thousandth of what gravity gives the bodies in
/// a step (and more than moves them by a hundred-thousandth of their size): tiny bodies would not move at all.
double Simulation::tolerance(double dt) const {
  const Vec3 extent = m_scene.start_positions.colwise().maxCoeff() - m_scene.start_positions.colwise().minCoeff();
  const double speed = std::max(1e-3 * m_plan.gravity.norm() * dt, 1e-5 * extent.norm() / dt);
  double squares = 0.0;
  for (const double mass : m_scene.model.mass)
    squares += mass * mass;
  return std::min(m_plan.settings.newton_tolerance, std::sqrt(squares) * speed);
}

NewtonReport Simulation::attempt(const Stage& stage, Trial& trial) {
  const NewtonSettings settings{tolerance(stage.dt), m_plan.settings.max_newton_iterations,
                                m_plan.settings.linear_tolerance};
  const NewtonProblem problem{m_scene.model,
                              m_terms,
                              m_held,
                              *m_matrix,
                              *m_linear.method,
                              m_threads,
                              [this](const Trial& at) -> const std::vector<Mat3>& {
                                estimate_node_rotations(m_scene, m_state.rotations, at, m_node_rotations);
                                return m_node_rotations;
                              }};
  Trial start;
  start.positions = m_state.positions;
  for (EnergyTerm* term : m_terms)
    term->begin_solve(stage, start);
  trial = first_guess(stage);
  NewtonReport total = minimise(problem, settings, stage, trial);
  for (int pass = 1; m_friction && total.converged && pass < FRICTION_PASSES; ++pass) {
    for (EnergyTerm* term : m_terms)
      term->begin_solve(stage, trial);
    total = sum_of(total, minimise(problem, settings, stage, trial));
  }
  return total;
}

Result<StepStats> Simulation::step(double end) {
  const auto start = std::chrono::steady_clock::now();
  StepStats stats;
  if (!(end > m_state.time))
    return make_error(ErrorCode::usage, "cannot step from {} s to {} s", m_state.time, end);
  NewtonReport total;
  for (;;) {
    const StepControl::Step next = m_control.next(m_state.time, end);
    const double target = next.lands ? end : m_state.time + next.dt;
    hold_nodes(target);
    const Stage stage = backward_euler(next.dt, target);
    Trial trial;
    const NewtonReport report = attempt(stage, trial);
    total = sum_of(total, report);
    if (report.converged) {
      accept(stage, trial);
      m_control.succeeded();
      stats.dt = next.dt;
      break;
    }
    ++stats.cuts;
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
  stiffen_crowded_contacts();
  report_energies(trial_at_rest_in_state(), stats);
  stats.total_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return stats;
}

void Simulation::accept(const Stage& stage, const Trial& trial) {
  for (const std::unique_ptr<ElementTerm>& elements : m_scene.elements)
    elements->advance_rotations(trial);
  for (Eigen::Index node = 0; node < trial.increments.rows(); ++node)
    m_state.rotations.row(node) = turned(m_state.rotations.row(node), trial.increments.row(node));
  m_state.positions = trial.positions;
  m_state.velocities = trial.velocities;
  m_state.angular = trial.angular;
  m_state.time = stage.time;
}

void Simulation::stiffen_crowded_contacts() {
  if (m_scene.model.planes.empty() || m_plan.settings.contact_stiffness)
    return;
  for (std::size_t body = 0; body < m_contact.stiffness.size(); ++body) {
    const PlaneGaps gaps = measure_plane_gaps(m_scene.model, m_contact, m_state.positions, static_cast<int>(body));
    if (gaps.least < CROWDED_SHARE * m_contact.distance)
      m_contact.stiffness[body] *= STIFFEN_BY;
  }
}

Trial Simulation::trial_at_rest_in_state() const {
  Trial trial;
  trial.positions = m_state.positions;
  trial.velocities = m_state.velocities;
  trial.angular = m_state.angular;
  trial.increments = Points::Zero(m_state.angular.rows(), 3);
  return trial;
}

void Simulation::report_energies(const Trial& trial, StepStats& stats) {
  const FemModel& model = m_scene.model;
  for (int node = 0; node < model.layout.node_count(); ++node) {
    stats.kinetic_energy += 0.5 * model.mass[node] * m_state.velocities.row(node).squaredNorm();
    if (model.rotary_mass[node] > 0.0)
      stats.kinetic_energy += 0.5 * model.rotary_mass[node] * m_state.angular.row(node).squaredNorm();
    stats.gravity_energy -= model.mass[node] * m_state.positions.row(node).dot(model.gravity);
  }
  for (const std::unique_ptr<ElementTerm>& elements : m_scene.elements) {
    const double total = elements->energy({}, trial);
    const bool curved = elements->group().curvature != CurvatureModel::none;
    const double elastic = curved ? elements->elastic_energy(trial) : total;
    stats.elastic_energy += elastic;
    stats.curvature_energy += total - elastic;
  }
}

Error Simulation::give_up(double dt, const NewtonReport& report) const {
  return make_error(
      ErrorCode::solver,
      "solids: no step from t = {:.6g} s: {} at dt = {:.3g} s (floor {:.3g} s): residual {:.3g} N s after {} "
      "iterations, tolerance {:.3g}, round-off about {:.3g}; the last good state is kept. Try a smaller "
      "fem.max_time_step, more fem.max_newton_iterations, a larger fem.newton_tolerance, or softer loads",
      m_state.time, report.trouble, dt, m_plan.settings.min_time_step, report.residual, report.iterations,
      m_plan.settings.newton_tolerance, report.round_off_floor);
}

SceneStatic Simulation::scene_static() const {
  return describe_bodies(m_plan);
}

Frame Simulation::snapshot(int number) const {
  const Trial trial = trial_at_rest_in_state();
  std::vector<std::vector<double>> energies;
  for (const std::unique_ptr<ElementTerm>& elements : m_scene.elements)
    energies.push_back(elements->element_energies(trial));
  return take_snapshot(m_scene, m_state, energies, number);
}

StateArchive Simulation::archive() const {
  StateArchive archive = archive_state(m_scene, m_state);
  archive.push_back({"fem/step_control", {2}, {m_control.current(), static_cast<double>(m_control.successes())}});
  archive.push_back({"fem/contact_stiffness", {m_contact.stiffness.size()}, m_contact.stiffness});
  m_linear.method->save(archive);
  return archive;
}

Status Simulation::restore(const StateArchive& archive) {
  FemState state = m_state;
  if (Status status = restore_state(archive, m_scene, state); !status)
    return status;
  const NamedArray* control = find_array(archive, "fem/step_control", 2);
  const NamedArray* stiffness = find_array(archive, "fem/contact_stiffness", m_contact.stiffness.size());
  if (control == nullptr || stiffness == nullptr)
    return make_error(ErrorCode::io, "checkpoint: fem/step_control or fem/contact_stiffness is missing");
  if (Status status = m_linear.method->restore(archive); !status)
    return status;
  m_state = std::move(state);
  m_control.restore(control->values[0], static_cast<int>(control->values[1]));
  m_contact.stiffness = stiffness->values;
  hold_nodes(m_state.time);
  for (const std::unique_ptr<ElementTerm>& elements : m_scene.elements)
    elements->update_rest_curvature(m_state.time);
  return {};
}

std::size_t Simulation::memory_bytes() const {
  std::size_t bytes = m_matrix->memory_bytes() + m_linear.method->memory_bytes();
  for (const std::unique_ptr<ElementTerm>& elements : m_scene.elements)
    bytes += elements->memory_bytes();
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
