#include "pipeline/run/simulate.h"

#include <algorithm>
#include <chrono>
#include <memory>

#include "pipeline/cache/checkpoints.h"
#include "pipeline/cache/frame_cache.h"
#include "pipeline/cache/verified_folder.h"
#include "pipeline/plan/plan_report.h"
#include "pipeline/report/csv.h"
#include "pipeline/run/collider_frames.h"
#include "pipeline/run/progress.h"
#include "pipeline/run/signals.h"
#include "shots/load.h"
#include "shots/resolved.h"
#include "sim/fem/fem_simulation.h"

namespace wry::pipeline {

namespace {

namespace fs = std::filesystem;

constexpr const char* STEP_COUNT = "run/step_count";

/// One run over the frames of a shot: what is open while it lasts.
class SimulationRun {
public:
  SimulationRun(const shots::Shot& shot, const ScenePlan& plan, const SimulateOptions& options, FrameCache cache,
                CheckpointStore checkpoints)
      : m_shot(shot)
      , m_plan(plan)
      , m_options(options)
      , m_cache(std::move(cache))
      , m_checkpoints(std::move(checkpoints)) {}

  Result<SimulateOutcome> go();

private:
  int first() const { return m_plan.sim.first_frame; }
  int last() const { return m_plan.sim.last_frame; }
  int last_complete_frame() const;
  Status start();
  Status restore(int last_complete);
  Status advance_to_frame(int frame, Progress& progress);
  Status keep_frame(int frame);
  Status write_checkpoint(int frame);
  Result<SceneStatic> whole_scene() const;

  const shots::Shot& m_shot;
  const ScenePlan& m_plan;
  const SimulateOptions& m_options;
  FrameCache m_cache;
  CheckpointStore m_checkpoints;
  std::unique_ptr<fem::FemSimulation> m_simulation;
  std::unique_ptr<CsvWriter> m_stats;
  SimulateOutcome m_outcome;
  int m_frame = 0; ///< the last frame whose time has been reached
  int m_steps = 0; ///< since the shot's first frame
};

int SimulationRun::last_complete_frame() const {
  int frame = first() - 1;
  while (frame < last() && m_cache.has_frame(frame + 1))
    ++frame;
  return frame;
}

Result<SceneStatic> SimulationRun::whole_scene() const {
  SceneStatic scene = m_simulation->scene_static();
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
  if (Status status = m_simulation->restore(checkpoint.state); !status)
    return status;
  m_frame = checkpoint.frame;
  m_outcome.resumed_from = checkpoint.frame;
  return {};
}

Status SimulationRun::start() {
  Result<std::unique_ptr<fem::FemSimulation>> made =
      fem::FemSimulation::create(m_plan.sim.fem, m_options.threads, m_options.isa);
  if (!made)
    return made.error();
  m_simulation = std::move(*made);
  m_outcome.solver = m_simulation->solver_choice().reason;
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
  Result<CsvWriter> stats = CsvWriter::open(m_options.out / "stats.csv", step_columns(), "step", kept_steps);
  if (!stats)
    return stats.error();
  m_stats = std::make_unique<CsvWriter>(std::move(*stats));
  return {};
}

Status SimulationRun::keep_frame(int frame) {
  if (m_cache.has_frame(frame)) {
    ++m_outcome.frames_kept;
    return {};
  }
  Frame snapshot = m_simulation->snapshot(frame);
  add_collider_poses(m_plan.sim, snapshot);
  if (Status status = m_cache.write_frame(snapshot); !status)
    return status;
  ++m_outcome.frames_written;
  return write_checkpoint(frame);
}

Status SimulationRun::write_checkpoint(int frame) {
  if (Status status = m_stats->sync(); !status)
    return status;
  StateArchive state = m_simulation->archive();
  state.push_back({STEP_COUNT, {1}, {static_cast<double>(m_steps)}});
  return m_checkpoints.write(state, frame, m_simulation->time());
}

Status SimulationRun::advance_to_frame(int frame, Progress& progress) {
  const double end = m_plan.sim.time_of(frame);
  while (m_simulation->time() < end) {
    const Result<fem::StepStats> stepped = m_simulation->step(end);
    if (!stepped)
      return stepped.error();
    ++m_steps;
    m_outcome.totals.add(*stepped);
    if (Status status = m_stats->append(step_row(m_steps, *stepped)); !status)
      return status;
    progress.update(m_simulation->time() * m_plan.sim.fps,
                    fmt::format("frame {}, {} Newton, dt {:.2g} s", frame, stepped->newton_iterations, stepped->dt));
    if (stop_requested()) {
      // Between frames is a safe point too: the state is whole after every step.
      if (Status status = write_checkpoint(m_frame); !status)
        return status;
      return stopped_by_signal(
          fmt::format("at t = {:.4f} s, frame {} of {} is the last; the same command goes on from here",
                      m_simulation->time(), m_frame, last()));
    }
  }
  m_frame = frame;
  return {};
}

Result<SimulateOutcome> SimulationRun::go() {
  const auto began = std::chrono::steady_clock::now();
  if (last_complete_frame() == last() && m_cache.has_static()) {
    m_outcome.frames_kept = last() - first() + 1;
    return m_outcome;
  }
  if (Status status = start(); !status)
    return status.error();
  m_outcome.frames_kept = m_frame - first();
  Progress progress(m_plan.name + ": simulate", m_plan.sim.time_of(last()) * m_plan.sim.fps,
                    m_simulation->time() * m_plan.sim.fps,
                    m_options.talk == SimulateOptions::Talk::quiet ? Progress::Mode::quiet : Progress::Mode::automatic);
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

/// Says which key made the frames that are there stale.
void explain_stale(const shots::Shot& shot, const fs::path& out, std::size_t stale) {
  fmt::print(stderr, "{}: {} cached frames were made from other inputs and are made again\n", *shot.shot.name, stale);
  const Result<shots::Shot> before = shots::load_shot((out / "shot.toml").string());
  if (!before)
    return;
  int shown = 0;
  for (const shots::KeyChange& change : shots::compare(shots::flatten(*before), shots::flatten(shot))) {
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

} // namespace

Result<SimulateOutcome> simulate(const shots::Shot& shot, const ScenePlan& plan, const SimulateOptions& options) {
  Result<FrameCache> cache = FrameCache::open_to_write(options.out / "frames", {plan.simulation_key, {}, {}});
  if (!cache)
    return cache.error();
  Result<CheckpointStore> checkpoints = CheckpointStore::open(
      options.out / "checkpoints", {plan.simulation_key, static_cast<int>(*shot.fem.checkpoint_every), {}});
  if (!checkpoints)
    return checkpoints.error();
  if (Status status = drop_damaged_frames(*cache, options.out / "frames"); !status)
    return status.error();
  if (options.start == SimulateOptions::Start::fresh) {
    if (Status status = cache->discard_all(); !status)
      return status.error();
    if (Status status = checkpoints->discard_all(); !status)
      return status.error();
  }
  if (const std::size_t stale = cache->stale_frames().size(); stale > 0)
    explain_stale(shot, options.out, stale);
  if (Status status =
          write_file_atomically(options.out / "shot.toml", shots::write_resolved(shot, options.out.string()));
      !status)
    return status.error();
  if (Status status = write_file_atomically(options.out / "plan.json", plan_json(plan)); !status)
    return status.error();
  return SimulationRun(shot, plan, options, std::move(*cache), std::move(*checkpoints)).go();
}

Result<MeasureTable> measure_frames(const ScenePlan& plan, const fs::path& out) {
  MeasureTable table;
  for (const MeasurePlan& measure : plan.measures)
    table.names.push_back(measure.name);
  Result<FrameCache> cache = FrameCache::open_to_read(out / "frames", plan.simulation_key);
  if (!cache)
    return cache.error();
  const Result<SceneStatic> scene = cache->read_static();
  if (!scene)
    return scene.error();
  std::vector<MeasurePlan> measures = plan.measures;
  std::string text = "frame,time_s";
  for (const std::string& name : table.names)
    text += "," + name;
  text += "\n";
  for (const CachedFrame& cached : cache->frames()) {
    const Result<Frame> frame = cache->read_frame(cached.number);
    if (!frame)
      return frame.error();
    std::vector<double> row;
    text += fmt::format("{},{}", frame->number, frame->time);
    for (std::size_t i = 0; i < measures.size(); ++i) {
      if (plan.measure_is_relative[i] && !measures[i].reference)
        measures[i].reference = evaluate_measure(measures[i], *scene, *frame);
      row.push_back(measured_value(measures[i], *scene, *frame));
      text += fmt::format(",{}", row.back());
    }
    text += "\n";
    table.frames.push_back(frame->number);
    table.rows.push_back(std::move(row));
  }
  if (!measures.empty()) {
    if (Status status = write_file_atomically(out / "measure.csv", text); !status)
      return status.error();
  }
  return table;
}

} // namespace wry::pipeline
