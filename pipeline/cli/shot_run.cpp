#include "pipeline/cli/shot_run.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/cli/expectations.h"
#include "pipeline/plan/build_id.h"
#include "pipeline/report/readable.h"
#include "pipeline/run/video.h"

namespace wry::pipeline {

namespace {

/// "3063 steps, shortest 0.000333 s, bound by the wave speed 2980, frame 83; 6.5 M particle-steps/s"
std::string particle_text(const StepTotals::Particles& totals) {
  std::string limits;
  for (int i = 0; i < 5; ++i) {
    if (totals.by_limit[i] > 0)
      limits += fmt::format("{}{} {}", limits.empty() ? "" : ", ", mpm::step_limit_name(static_cast<mpm::StepLimit>(i)),
                            totals.by_limit[i]);
  }
  std::string text = fmt::format("{} steps, shortest {:.3g} s, bound by {}; {:.3g} M particle-steps/s", totals.steps,
                                 totals.smallest_dt, limits, 1e-3 * totals.particle_steps / totals.total_ms);
  if (totals.cut > 0)
    text += fmt::format("; mpm.time_step was unstable and cut in {} of them", totals.cut);
  return text;
}

void print_totals(const ScenePlan& plan, const SimulateOutcome& outcome) {
  const StepTotals& totals = outcome.totals;
  if (outcome.frames_written == 0) {
    fmt::print("{}: all {} frames were there already\n", plan.name, outcome.frames_kept);
    return;
  }
  fmt::print("{}: {} frames {} in {}{}\n", plan.name, outcome.frames_written,
             outcome.what == SimulateOutcome::What::grains
                 ? "given other grains from the fields that were kept, without simulating,"
                 : "simulated",
             human_duration(outcome.wall_seconds),
             outcome.resumed_from > 0 ? fmt::format(", resumed from frame {}", outcome.resumed_from) : "");
  if (totals.steps > 0)
    fmt::print("  solids: {} steps, {} Newton iterations, {} linear iterations, {} cuts; worst residual {:.2g} N s\n",
               totals.steps, totals.newton_iterations, totals.linear_iterations, totals.cuts, totals.worst_residual);
  if (totals.particles.steps > 0)
    fmt::print("  particles: {}\n", particle_text(totals.particles));
}

/// Steps and their cost; of each method only where it ran.
nlohmann::json spent(const StepTotals& totals) {
  nlohmann::json spent = nlohmann::json::object();
  if (totals.steps > 0)
    spent = {{"steps", totals.steps},
             {"newton_iterations", totals.newton_iterations},
             {"linear_iterations", totals.linear_iterations},
             {"cuts", totals.cuts},
             {"projected_elements", totals.projected_elements},
             {"most_contacts", totals.most_contacts},
             {"worst_residual_Ns", totals.worst_residual},
             {"evaluate_ms", totals.evaluate_ms},
             {"assemble_ms", totals.assemble_ms},
             {"solve_ms", totals.solve_ms},
             {"total_ms", totals.total_ms}};
  if (totals.particles.steps > 0)
    spent["particles"] = {{"steps", totals.particles.steps},
                          {"particle_steps", totals.particles.particle_steps},
                          {"shortest_step_s", totals.particles.smallest_dt},
                          {"steps_cut", totals.particles.cut},
                          {"sort_ms", totals.particles.sort_ms},
                          {"scatter_ms", totals.particles.scatter_ms},
                          {"grid_ms", totals.particles.grid_ms},
                          {"gather_ms", totals.particles.gather_ms},
                          {"grain_updates", totals.particles.grain_updates},
                          {"grains_ms", totals.particles.grains_ms},
                          {"total_ms", totals.particles.total_ms}};
  return spent;
}

nlohmann::json verdicts(const std::vector<Judgement>& judgements) {
  nlohmann::json verdicts = nlohmann::json::object();
  for (const Judgement& judgement : judgements)
    verdicts[judgement.name] = judgement.verdict == Judgement::Verdict::holds   ? "holds"
                               : judgement.verdict == Judgement::Verdict::fails ? "fails: " + judgement.why
                                                                                : "not judged: " + judgement.why;
  return verdicts;
}

Status write_summary(const ShotSession& session, const ScenePlan& plan, const SimulateOutcome& outcome,
                     const MeasureTable& table) {
  const StepTotals& totals = outcome.totals;
  nlohmann::json measures = nlohmann::json::object();
  for (std::size_t i = 0; i < table.names.size() && !table.rows.empty(); ++i)
    measures[table.names[i]] = {{"first", table.rows.front()[i]}, {"last", table.rows.back()[i]}};
  const nlohmann::json summary = {{"shot", plan.name},
                                  {"version", std::string(version())},
                                  {"simulation_build", std::string(simulation_build())},
                                  {"isa", std::string(isa_name(session.isa))},
                                  {"simulation_key", plan.simulation_key},
                                  {"frames_written", outcome.frames_written},
                                  {"frames_kept", outcome.frames_kept},
                                  {"resumed_from_frame", outcome.resumed_from},
                                  {"solver", outcome.solver},
                                  {"wall_seconds", outcome.wall_seconds},
                                  {"this_run", spent(totals)},
                                  {"measures", measures},
                                  {"expectations", verdicts(judge_expectations(session.shot, table))}};
  return write_file_atomically(session.out / "summary.json",
                               summary.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

} // namespace

Result<MeasureTable> simulate_session(const ShotSession& session, const ScenePlan& plan, const Invocation& invocation) {
  for (const std::string& warning : plan.warnings)
    fmt::print(stderr, "warning: {}\n", warning);
  SimulateOptions options;
  options.out = session.out;
  options.threads = invocation.threads;
  options.isa = session.isa;
  options.start = invocation.fresh ? SimulateOptions::Start::fresh : SimulateOptions::Start::resume;
  options.talk = invocation.quiet ? SimulateOptions::Talk::quiet : SimulateOptions::Talk::normal;
  options.shortage = invocation.ignore_limits ? Shortage::go_on : Shortage::refuse;
  const Result<SimulateOutcome> outcome = simulate(session.shot, plan, options);
  if (!outcome)
    return outcome.error();
  Result<MeasureTable> table = measure_frames(plan, session.out, Threads(invocation.threads));
  if (!table)
    return table.error();
  if (outcome->frames_written > 0) {
    if (Status status = write_summary(session, plan, *outcome, *table); !status)
      return status.error();
  }
  if (!invocation.quiet)
    print_totals(plan, *outcome);
  return table;
}

Status draw_session(const ShotSession& session, const Invocation& invocation) {
  const Result<render::GlBackend> backend = render::parse_gl_backend(invocation.gl);
  if (!backend)
    return backend.error();
  RenderOptions options;
  options.out = session.out;
  options.frames = session.frames;
  options.backend = *backend;
  options.source = invocation.follow ? RenderOptions::Frames::follow : RenderOptions::Frames::cached;
  options.talk = invocation.quiet ? RenderOptions::Talk::quiet : RenderOptions::Talk::normal;
  const int processes = rendering_processes(invocation, session.frames.size());
  if (!invocation.part.empty()) {
    if (std::sscanf(invocation.part.c_str(), "%d/%d", &options.part, &options.parts) != 2 || options.parts < 1)
      return make_error(ErrorCode::usage, "--part {}: expected i/n", invocation.part);
  } else if (processes > 1) {
    std::vector<std::vector<std::string>> command_lines;
    for (int part = 0; part < processes; ++part) {
      std::vector<std::string> words = {"render"};
      words.insert(words.end(), invocation.original_arguments.begin(), invocation.original_arguments.end());
      std::erase_if(words, [](const std::string& word) { return word == "--fresh"; });
      words.push_back("--part");
      words.push_back(fmt::format("{}/{}", part, processes));
      command_lines.push_back(std::move(words));
    }
    return run_self_to_success(command_lines);
  }
  const Result<RenderOutcome> outcome = render_frames(session.shot, options);
  return outcome ? Status() : Status(outcome.error());
}

Status encode_session(const ShotSession& session) {
  for (const shots::Located<shots::View>& view : session.shot.render.views) {
    std::vector<std::filesystem::path> pictures;
    for (const int frame : session.frames)
      pictures.push_back(picture_path(session.out, *session.shot.shot.name, view->name, frame));
    if (*session.shot.render.contact_sheet && !session.frames.empty()) {
      if (Status status = write_contact_sheet(session.shot, session.out, view->name, session.frames); !status)
        return status;
    }
    if (pictures.size() < 2)
      continue;
    const Status status =
        encode_film(pictures, session.out / "images" / fmt::format("{}.{}.mp4", *session.shot.shot.name, view->name),
                    *session.shot.shot.fps);
    if (!status)
      return status;
  }
  return {};
}

} // namespace wry::pipeline
