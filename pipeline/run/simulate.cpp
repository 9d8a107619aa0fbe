#include "pipeline/run/simulate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include "pipeline/cache/checkpoints.h"
#include "pipeline/cache/field_store.h"
#include "pipeline/cache/frame_cache.h"
#include "pipeline/cache/verified_folder.h"
#include "pipeline/plan/cost.h"
#include "pipeline/plan/plan_report.h"
#include "pipeline/report/csv.h"
#include "pipeline/run/collider_frames.h"
#include "pipeline/run/progress.h"
#include "pipeline/run/signals.h"
#include "pipeline/run/watchdog.h"
#include "shots/load.h"
#include "shots/resolved.h"
#include "sim/fem/fem_simulation.h"
#include "sim/mpm/mpm_simulation.h"

namespace wry::pipeline {

namespace {

namespace fs = std::filesystem;

constexpr const char* STEP_COUNT = "run/step_count";
constexpr const char* FIELDS = "fields";

/// One run over the frames of a shot: what is open while it lasts.
class SimulationRun {
public:
  SimulationRun(const ScenePlan& plan, const SimulateOptions& options, FrameCache cache, CheckpointStore checkpoints,
                std::optional<FieldStore> fields)
      : m_plan(plan)
      , m_options(options)
      , m_cache(std::move(cache))
      , m_checkpoints(std::move(checkpoints))
      , m_fields(std::move(fields))
      , m_columns(plan.sim) {}

  Result<SimulateOutcome> go();

private:
  bool is_complete() const;
  bool keeps_fields() const { return m_plan.sim.mpm.settings.keep_fields; }
  Result<bool> only_grains_changed() const;
  Result<SimulateOutcome> make_grains_again();
  Status make_grains_of_frame(int frame, const FrameCache& before);
  int first() const { return m_plan.sim.first_frame; }
  int last() const { return m_plan.sim.last_frame; }
  int last_complete_frame() const;
  Status start();
  Status restore(int last_complete);
  Status make_simulations();
  Status require_room(const CostEstimate& cost) const;
  double time() const;
  Status advance_to_frame(int frame, Progress& progress);
  template <class Simulation> Status advance(Simulation& simulation, int frame, Progress& progress);
  Status keep_frame(int frame);
  Frame snapshot(int frame) const;
  Frame simulated_bodies(int frame) const;
  Status write_checkpoint(int frame);
  Result<SceneStatic> whole_scene() const;

  const ScenePlan& m_plan;
  const SimulateOptions& m_options;
  FrameCache m_cache;
  CheckpointStore m_checkpoints;
  std::optional<FieldStore> m_fields;
  std::unique_ptr<fem::FemSimulation> m_solids;    ///< nullptr: there are none
  std::unique_ptr<mpm::MpmSimulation> m_particles; ///< nullptr: there are none
  StepColumns m_columns;
  std::unique_ptr<CsvWriter> m_stats;
  std::unique_ptr<Watchdog> m_watchdog;
  SimulateOutcome m_outcome;
  int m_frame = 0; ///< the last frame whose time has been reached
  int m_steps = 0; ///< since the shot's first frame
};

int SimulationRun::last_complete_frame() const {
  int frame = first() - 1;
  while (frame < last() && m_cache.has_frame(frame + 1) && (!keeps_fields() || m_fields->has(frame + 1)))
    ++frame;
  return frame;
}

bool SimulationRun::is_complete() const {
  return last_complete_frame() == last() && m_cache.has_static();
}

Result<SceneStatic> SimulationRun::whole_scene() const {
  SceneStatic scene;
  if (m_solids)
    scene = m_solids->scene_static();
  if (m_particles) {
    for (SceneBody& body : m_particles->scene_static().bodies)
      scene.bodies.push_back(std::move(body));
  }
  for (std::size_t body = 0; body < m_plan.body_looks.size(); ++body)
    scene.bodies[body].look = m_plan.body_looks[body];
  if (Status status = add_colliders(m_plan.sim, scene); !status)
    return status.error();
  return scene;
}

Status SimulationRun::restore(int last_complete) {
  Result<CheckpointStore::Found> found = m_checkpoints.latest_at_or_before(last_complete);
  if (!found)
    return found.error();
  for (const std::string& warning : found->warnings)
    fmt::print(stderr, "warning: {}\n", warning);
  if (!found->checkpoint)
    return {};
  Checkpoint& checkpoint = *found->checkpoint;
  const auto counter = std::find_if(checkpoint.state.begin(), checkpoint.state.end(),
                                    [](const NamedArray& array) { return array.name == STEP_COUNT; });
  if (counter != checkpoint.state.end()) {
    m_steps = static_cast<int>(counter->values.at(0));
    checkpoint.state.erase(counter);
  }
  if (m_solids) {
    if (Status status = m_solids->restore(checkpoint.state); !status)
      return status;
  }
  if (m_particles) {
    if (Status status = m_particles->restore(checkpoint.state); !status)
      return status;
  }
  m_frame = checkpoint.frame;
  m_outcome.resumed_from = checkpoint.frame;
  return {};
}

Status SimulationRun::require_room(const CostEstimate& cost) const {
  if (m_options.shortage == Shortage::go_on)
    return {};
  const Result<Machine> machine = read_machine(m_options.out, m_options.system);
  return machine ? require_resources(m_plan.name, cost, last() - first() + 1, *machine) : Status(machine.error());
}

Status SimulationRun::make_simulations() {
  if (Status status = require_room(m_plan.cost); !status)
    return status;
  if (!m_plan.sim.fem.bodies.empty()) {
    Result<std::unique_ptr<fem::FemSimulation>> made =
        fem::FemSimulation::create(m_plan.sim.fem, m_options.threads, m_options.isa);
    if (!made)
      return made.error();
    m_solids = std::move(*made);
    m_outcome.solver = m_solids->solver_choice().reason;
    // What its factors take is known only now.
    CostEstimate with_solver = m_plan.cost;
    add_cost_of_solver(with_solver, *m_solids);
    if (Status status = require_room(with_solver); !status)
      return status;
  }
  if (!m_plan.sim.mpm.bodies.empty()) {
    Result<std::unique_ptr<mpm::MpmSimulation>> made =
        mpm::MpmSimulation::create(m_plan.sim.mpm, m_options.threads, m_options.isa);
    if (!made)
      return made.error();
    m_particles = std::move(*made);
    if (m_outcome.solver.empty())
      m_outcome.solver = "explicit";
  }
  return {};
}

/// How far all of the simulation is.
double SimulationRun::time() const {
  if (m_solids && m_particles)
    return std::min(m_solids->time(), m_particles->time());
  return m_solids ? m_solids->time() : m_particles->time();
}

Status SimulationRun::start() {
  if (Status status = make_simulations(); !status)
    return status;
  m_frame = first();
  const int complete = last_complete_frame();
  if (complete >= first() && m_cache.has_static()) {
    if (Status status = restore(complete); !status)
      return status;
  } else {
    const Result<SceneStatic> scene = whole_scene();
    if (!scene)
      return scene.error();
    if (Status status = m_cache.write_static(*scene); !status)
      return status;
  }
  const int kept_steps = m_steps;
  Result<CsvWriter> stats = CsvWriter::open(m_options.out / "stats.csv", m_columns.names(), "step", kept_steps);
  if (!stats)
    return stats.error();
  m_stats = std::make_unique<CsvWriter>(std::move(*stats));
  return {};
}

Frame SimulationRun::snapshot(int frame) const {
  Frame whole = simulated_bodies(frame);
  add_collider_poses(m_plan.sim, whole);
  return whole;
}

Frame SimulationRun::simulated_bodies(int frame) const {
  Frame whole;
  if (m_solids)
    whole = m_solids->snapshot(frame);
  if (m_particles) {
    Frame particles = m_particles->snapshot(frame);
    whole.number = particles.number;
    whole.time = particles.time;
    for (FrameBody& body : particles.bodies)
      whole.bodies.push_back(std::move(body));
  }
  return whole;
}

Status SimulationRun::keep_frame(int frame) {
  const bool is_new = !m_cache.has_frame(frame);
  if (is_new) {
    if (Status status = m_cache.write_frame(snapshot(frame)); !status)
      return status;
  }
  // After the frame: where there are fields of a frame, the frame is of the same matter.
  if (keeps_fields() && m_particles) {
    StateArchive fields;
    mpm::archive_updates(m_particles->take_fields(), FIELDS, fields);
    if (!m_fields->has(frame)) {
      if (Status status = m_fields->write(frame, fields); !status)
        return status;
    }
  }
  if (!is_new) {
    ++m_outcome.frames_kept;
    return {};
  }
  ++m_outcome.frames_written;
  return write_checkpoint(frame);
}

Status SimulationRun::write_checkpoint(int frame) {
  if (Status status = m_stats->sync(); !status)
    return status;
  StateArchive state;
  if (m_solids)
    state = m_solids->archive();
  if (m_particles) {
    for (NamedArray& array : m_particles->archive())
      state.push_back(std::move(array));
  }
  state.push_back({STEP_COUNT, {1}, {static_cast<double>(m_steps)}});
  return m_checkpoints.write(state, frame, time());
}

std::string step_text(const fem::StepStats& stats) {
  return fmt::format("{} Newton, dt {:.2g} s", stats.newton_iterations, stats.dt);
}

std::string step_text(const mpm::StepStats& stats) {
  return fmt::format("{} particles, dt {:.2g} s ({})", stats.particles, stats.dt, mpm::step_limit_name(stats.limit));
}

template <class Simulation> Status SimulationRun::advance(Simulation& simulation, int frame, Progress& progress) {
  const double end = m_plan.sim.time_of(frame);
  while (simulation.time() < end) {
    const auto stepped = simulation.step(end);
    if (!stepped)
      return stepped.error();
    ++m_steps;
    m_outcome.totals.add(*stepped);
    if (Status status = m_stats->append(m_columns.row(m_steps, *stepped)); !status)
      return status;
    m_watchdog->progress(fmt::format("step {}, t = {:.4f} s", m_steps, time()));
    progress.update(time() * m_plan.sim.fps, fmt::format("frame {}, {}", frame, step_text(*stepped)));
    if (stop_requested()) {
      // Between frames is a safe point too: the state is whole after every step.
      if (Status status = write_checkpoint(m_frame); !status)
        return status;
      return stopped_by_signal(fmt::format(
          "at t = {:.4f} s, frame {} of {} is the last; the same command goes on from here", time(), m_frame, last()));
    }
  }
  return {};
}

/// Nothing couples the two methods, so each goes to the frame by itself.
Status SimulationRun::advance_to_frame(int frame, Progress& progress) {
  if (m_solids) {
    if (Status status = advance(*m_solids, frame, progress); !status)
      return status;
  }
  if (m_particles) {
    if (Status status = advance(*m_particles, frame, progress); !status)
      return status;
  }
  m_frame = frame;
  return {};
}

Result<SimulateOutcome> SimulationRun::go() {
  const auto began = std::chrono::steady_clock::now();
  if (is_complete()) {
    m_outcome.frames_kept = last() - first() + 1;
    return m_outcome;
  }
  const Result<bool> only_grains = only_grains_changed();
  if (!only_grains)
    return only_grains.error();
  if (*only_grains)
    return make_grains_again();
  if (m_fields) {
    if (Status status = m_fields->discard_all_but(keeps_fields() ? m_plan.matter_key : std::string()); !status)
      return status.error();
  }
  if (Status status = start(); !status)
    return status.error();
  m_outcome.frames_kept = m_frame - first();
  Progress progress(m_plan.name + ": simulate", m_plan.sim.time_of(last()) * m_plan.sim.fps, time() * m_plan.sim.fps,
                    m_options.talk == SimulateOptions::Talk::quiet ? Progress::Mode::quiet : Progress::Mode::automatic);
  m_watchdog = std::make_unique<Watchdog>(Watchdog::Settings{std::chrono::minutes(30), m_plan.name, {}});
  Status status = keep_frame(m_frame);
  while (status.ok() && m_frame < last()) {
    status = advance_to_frame(m_frame + 1, progress);
    if (status.ok())
      status = keep_frame(m_frame);
  }
  progress.finish();
  m_outcome.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  if (!status)
    return status.error();
  return m_outcome;
}

/// Whether there is a frame of the same matter for each, with what carried its grains, and grains of other settings.
Result<bool> SimulationRun::only_grains_changed() const {
  if (!keeps_fields() || m_cache.stale_frames().empty())
    return false;
  const Result<FrameCache> before = FrameCache::open_to_read(m_options.out / "frames");
  if (!before)
    return before.error();
  for (int frame = first(); frame <= last(); ++frame) {
    if (!m_fields->has(frame) || !before->has_frame(frame))
      return false;
  }
  return true;
}

Status SimulationRun::make_grains_of_frame(int frame, const FrameCache& before) {
  const Result<StateArchive> kept = m_fields->read(frame);
  if (!kept)
    return kept.error();
  const Result<std::vector<mpm::GrainUpdate>> updates = mpm::restore_updates(*kept, FIELDS);
  if (!updates)
    return updates.error();
  if (Status status = m_particles->replay(*updates); !status)
    return status;
  if (m_cache.has_frame(frame))
    return {};
  Result<Frame> was = before.read_frame(frame);
  if (!was)
    return was.error();
  Frame now = simulated_bodies(frame);
  const std::size_t matter = m_plan.sim.fem.bodies.size() + m_plan.sim.mpm.bodies.size();
  for (std::size_t body = 0; body < matter; ++body)
    now.bodies[body] = std::move(was->bodies[body]);
  now.time = was->time;
  add_collider_poses(m_plan.sim, now);
  ++m_outcome.frames_written;
  return m_cache.write_frame(now);
}

/// The matter of the frames that are there, and grains that follow it anew: nothing is simulated.
Result<SimulateOutcome> SimulationRun::make_grains_again() {
  const auto began = std::chrono::steady_clock::now();
  if (Status status = make_simulations(); !status)
    return status.error();
  const Result<SceneStatic> scene = whole_scene();
  if (!scene)
    return scene.error();
  const Result<FrameCache> before = FrameCache::open_to_read(m_options.out / "frames");
  if (!before)
    return before.error();
  if (Status status = m_cache.write_static(*scene); !status)
    return status.error();
  m_outcome.frames_kept = static_cast<int>(m_cache.frames().size());
  m_outcome.what = SimulateOutcome::What::grains;
  for (int frame = first(); frame <= last(); ++frame) {
    if (Status status = make_grains_of_frame(frame, *before); !status)
      return status.error();
    if (stop_requested())
      return stopped_by_signal(
          fmt::format("after the grains of frame {} of {}; the same command goes on", frame, last()));
  }
  m_outcome.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return m_outcome;
}

/// Says which key made the frames that are there stale. Both shots are as the folder has them, so that an asset goes by
/// the same name in both.
void explain_stale(const shots::Shot& shot, const Result<shots::Shot>& before, const Result<shots::Shot>& now,
                   std::size_t stale) {
  fmt::print(stderr, "{}: {} cached frames were made from other inputs and are made again\n", *shot.shot.name, stale);
  if (!before || !now)
    return;
  int shown = 0;
  for (const shots::KeyChange& change : shots::compare(shots::flatten(*before), shots::flatten(*now))) {
    if (change.effect != shots::Effect::simulation || ++shown > 5)
      continue;
    fmt::print(stderr, "  {}: {} -> {}\n", change.key, change.before.empty() ? "(absent)" : change.before,
               change.after.empty() ? "(absent)" : change.after);
  }
}

/// Drops frames from the first damaged one on, so that they are made again.
Status drop_damaged_frames(FrameCache& cache, const fs::path& frames) {
  const Result<FolderReport> report = check_folder(frames);
  if (!report)
    return report.error();
  for (const FolderFinding& finding : report->findings) {
    if (!is_damage(finding.kind))
      continue;
    fmt::print(stderr, "warning: {}; it is made again\n", finding.message);
    for (const CachedFrame& cached : cache.frames()) {
      if (frame_file_name(cached.number) == finding.name)
        return cache.discard_after(cached.number - 1);
    }
    return cache.discard_all();
  }
  return {};
}

/// Where what carries grains is kept: nothing where it is not, and never was.
Result<std::optional<FieldStore>> open_fields(const ScenePlan& plan, const SimulateOptions& options) {
  const fs::path folder = options.out / "fields";
  if (!plan.sim.mpm.settings.keep_fields && !fs::exists(folder))
    return std::optional<FieldStore>();
  Result<FieldStore> opened = FieldStore::open(folder, plan.matter_key);
  if (!opened)
    return opened.error();
  if (options.start == SimulateOptions::Start::fresh) {
    if (Status status = opened->discard_all_but(""); !status)
      return status.error();
  }
  const Result<std::vector<std::string>> damaged = opened->discard_damaged();
  if (!damaged)
    return damaged.error();
  for (const std::string& finding : *damaged)
    fmt::print(stderr, "warning: {}; it is made again\n", finding);
  return std::optional<FieldStore>(std::move(*opened));
}

} // namespace

Result<SimulateOutcome> simulate(const shots::Shot& shot, const ScenePlan& plan, const SimulateOptions& options) {
  Result<FrameCache> cache = FrameCache::open_to_write(options.out / "frames", {plan.simulation_key, {}, {}});
  if (!cache)
    return cache.error();
  Result<CheckpointStore> checkpoints =
      CheckpointStore::open(options.out / "checkpoints", {.key = plan.simulation_key,
                                                          .keep_every = static_cast<int>(*shot.fem.checkpoint_every),
                                                          .faults = {},
                                                          .keep_last = static_cast<int>(*shot.fem.keep)});
  if (!checkpoints)
    return checkpoints.error();
  if (Status status = drop_damaged_frames(*cache, options.out / "frames"); !status)
    return status.error();
  Result<std::optional<FieldStore>> fields = open_fields(plan, options);
  if (!fields)
    return fields.error();
  if (options.start == SimulateOptions::Start::fresh) {
    if (Status status = cache->discard_all(); !status)
      return status.error();
    if (Status status = checkpoints->discard_all(); !status)
      return status.error();
  }
  const std::string resolved = (options.out / "shot.toml").string();
  const Result<shots::Shot> before = shots::load_shot(resolved);
  if (Status status = write_file_atomically(resolved, shots::write_resolved(shot, options.out.string())); !status)
    return status.error();
  if (const std::size_t stale = cache->stale_frames().size(); stale > 0)
    explain_stale(shot, before, shots::load_shot(resolved), stale);
  if (Status status = write_file_atomically(options.out / "plan.json", plan_json(plan)); !status)
    return status.error();
  return SimulationRun(plan, options, std::move(*cache), std::move(*checkpoints), std::move(*fields)).go();
}

} // namespace wry::pipeline
