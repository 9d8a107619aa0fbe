#include "pipeline/cli/study_session.h"

#include <algorithm>
#include <thread>

#include "pipeline/cli/output_folder.h"
#include "pipeline/run/engines/job_process.h"
#include "pipeline/study/study_display.h"

namespace wry::pipeline {

namespace {

int cores() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// --jobs, or one process per core.
int jobs_asked(const Invocation& invocation) {
  return invocation.jobs > 0 ? invocation.jobs : cores();
}

} // namespace

StudyRequest study_request(const ShotSession& session, const Invocation& invocation) {
  StudyRequest request;
  request.shot = invocation.subject;
  request.folder = std::filesystem::absolute(session.out).lexically_normal();
  request.sets = invocation.sets;
  request.frames = invocation.frames;
  request.isa = session.isa;
  request.gl = invocation.gl;
  request.threads = invocation.threads > 0 ? invocation.threads : std::max(1, cores() / jobs_asked(invocation));
  request.frames_per_job = invocation.chunk;
  request.shortage = invocation.ignore_limits ? Shortage::go_on : Shortage::refuse;
  return request;
}

Result<Study> run_study_session(const StudyRequest& request, const Study& study, const Invocation& invocation) {
  Result<std::unique_ptr<Engine>> engine = make_engine(invocation.engine);
  if (!engine)
    return engine.error();
  StudyDisplay display(request.part, invocation.quiet ? StudyDisplay::Talk::quiet : StudyDisplay::Talk::normal);
  EngineSettings settings;
  settings.jobs = jobs_asked(invocation);
  settings.observer = [&](std::span<const JobState> states) { display.show(states); };
  const StudySelection selection = invocation.fresh         ? StudySelection::all
                                   : invocation.only_failed ? StudySelection::only_failed
                                                            : StudySelection::unfinished;
  return run_study(request, study, **engine, settings, selection);
}

Result<std::optional<Study>> run_held_study(StudyRequest& request, std::vector<Variant>& variants,
                                            const Invocation& invocation) {
  request.failures_are_results = true;
  if (Status status = number_variants(variants, request.folder); !status)
    return status.error();
  request.variants = variants;
  Result<Study> study = read_study(request);
  if (!study)
    return study.error();
  if (invocation.list || invocation.dry_run) {
    print_job_graph(*study, invocation);
    return std::optional<Study>();
  }
  if (!invocation.collect)
    study = run_study_session(request, *study, invocation);
  if (!study)
    return study.error();
  return std::optional<Study>(std::move(*study));
}

Result<std::optional<HeldStudy>> hold_study(StudyRequest& request, std::vector<Variant>& variants,
                                            const std::optional<std::string>& frames, const Invocation& invocation) {
  request.stages = StudyStages::simulate;
  if (request.frames.empty() && frames)
    request.frames = *frames;
  std::optional<FolderLock> lock;
  if (!invocation.list && !invocation.dry_run) {
    Result<FolderLock> taken = take_folder(request.folder);
    if (!taken)
      return taken.error();
    lock = std::move(*taken);
  }
  Result<std::optional<Study>> study = run_held_study(request, variants, invocation);
  if (!study)
    return study.error();
  if (!*study)
    return std::optional<HeldStudy>();
  return std::optional<HeldStudy>(HeldStudy{std::move(**study), std::move(*lock)});
}

void print_job_graph(const Study& study, const Invocation& invocation) {
  if (invocation.json) {
    std::fputs(job_graph_json(study.graph, this_program()).c_str(), stdout);
    return;
  }
  for (const StudyRow& row : study.rows) {
    const auto jobs = std::count_if(study.graph.jobs.begin(), study.graph.jobs.end(),
                                    [&](const Job& job) { return job.variant == row.variant.id(); });
    fmt::print("{}  {}  ({} jobs, {}{}{})\n", row.variant.id(), row.variant.name, jobs, outcome_name(row.outcome),
               row.reason.empty() ? "" : ": ", row.reason);
  }
}

} // namespace wry::pipeline
