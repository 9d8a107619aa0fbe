#include "pipeline/study/study.h"

#include <algorithm>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/study/study_jobs.h"
#include "pipeline/study/study_result.h"
#include "shots/load.h"

namespace wry::pipeline {

namespace {

/// The variant's shot, with the user's --set below its own values.
Result<shots::Shot> load_variant(const StudyRequest& request, const Variant& variant) {
  std::vector<shots::Override> overrides;
  for (const std::string& text : request.sets) {
    Result<shots::Override> parsed = shots::parse_override(text);
    if (!parsed)
      return parsed.error();
    overrides.push_back(std::move(*parsed));
  }
  for (const Parameter& parameter : variant.parameters)
    overrides.push_back({parameter.key, parameter.value, {}});
  return shots::load_shot(request.shot, overrides);
}

Status prepare_row(const StudyRequest& request, StudyRow& row) {
  Result<shots::Shot> shot = load_variant(request, row.variant);
  if (!shot) {
    row.outcome = StudyOutcome::failed;
    row.exit_code = static_cast<int>(shot.error().code);
    row.reason = shot.error().message;
    return {};
  }
  row.frames = shot->shot.frames->frames();
  if (!request.frames.empty()) {
    const Result<shots::FrameRange> asked = shots::FrameRange::parse(request.frames);
    if (!asked)
      return make_error(ErrorCode::usage, "--frames {}: {}", request.frames, asked.error().message);
    row.frames = asked->frames();
  }
  row.shot = std::move(*shot);
  return {};
}

/// The frames that a variant draws, as if they were its own.
Status link_frames(const StudyRequest& request, const StudyRow& row) {
  for (int repeat = 0; repeat < request.repeats; ++repeat) {
    const std::filesystem::path folder = repeat == 0 ? row.folder : row.folder / timing_stage(repeat);
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (!error && !std::filesystem::exists(folder / "frames"))
      std::filesystem::create_directory_symlink(request.frames_of / "frames", folder / "frames", error);
    if (error)
      return make_error(ErrorCode::cannot_write, "{}: {}", (folder / "frames").string(), error.message());
  }
  return {};
}

/// Throws away what earlier runs of a variant made, whole or half: a job that found it would go on from there, and its
/// record would tell the time of what was left to do.
Status throw_away(const StudyRequest& request, const StudyRow& row) {
  std::vector<std::string> names = {"frames", "checkpoints", "images", "stats.csv", "measure.csv"};
  for (int repeat = 1; repeat < request.repeats; ++repeat)
    names.push_back(timing_stage(repeat));
  for (const std::string& name : names) {
    std::error_code error;
    std::filesystem::remove_all(row.folder / name, error); // a link goes, not what it leads to
    if (error)
      return make_error(ErrorCode::cannot_write, "{}: {}", (row.folder / name).string(), error.message());
  }
  return {};
}

bool is_selected(const Study& study, const StudyRow& row, StudySelection selection) {
  switch (selection) {
  case StudySelection::unfinished:
    return !is_finished(row.outcome) && !(study.failures_are_results && row.outcome == StudyOutcome::failed);
  case StudySelection::only_failed:
    return row.outcome == StudyOutcome::failed;
  case StudySelection::all:
    break;
  }
  return true;
}

} // namespace

std::string_view outcome_name(StudyOutcome outcome) {
  switch (outcome) {
  case StudyOutcome::done:
    return "done";
  case StudyOutcome::expectation_failed:
    return "expectation failed";
  case StudyOutcome::failed:
    return "failed";
  case StudyOutcome::stopped:
    return "stopped";
  case StudyOutcome::not_run:
    break;
  }
  return "not run";
}

bool is_finished(StudyOutcome outcome) {
  return outcome == StudyOutcome::done || outcome == StudyOutcome::expectation_failed;
}

Result<Study> read_study(const StudyRequest& request) {
  Study study;
  study.graph.folder = request.folder;
  study.failures_are_results = request.failures_are_results;
  for (const Variant& variant : request.variants) {
    StudyRow row;
    row.variant = variant;
    row.folder = request.folder / request.part / variant.id();
    if (Status status = prepare_row(request, row); !status)
      return status.error();
    if (row.shot) {
      const Result<std::vector<Job>> jobs = jobs_of(request, row);
      if (!jobs)
        return jobs.error();
      read_outcome(request, *jobs, row);
      study.graph.jobs.insert(study.graph.jobs.end(), jobs->begin(), jobs->end());
    }
    study.rows.push_back(std::move(row));
  }
  if (!request.collect.empty())
    study.graph.jobs.push_back(collecting_job(request, study.graph));
  return study;
}

JobGraph select_jobs(const Study& study, StudySelection selection) {
  JobGraph selected{study.graph.folder, {}};
  for (const Job& job : study.graph.jobs) {
    const auto row = std::find_if(study.rows.begin(), study.rows.end(),
                                  [&](const StudyRow& r) { return r.variant.id() == job.variant; });
    if (row == study.rows.end() || is_selected(study, *row, selection))
      selected.jobs.push_back(job);
  }
  const bool only_collects = selected.jobs.size() == 1 && selected.jobs.front().variant.empty();
  if (only_collects)
    selected.jobs.clear();
  return selected;
}

Result<Study> run_study(const StudyRequest& request, const Study& study, Engine& engine, const EngineSettings& settings,
                        StudySelection selection) {
  const JobGraph selected = select_jobs(study, selection);
  for (const Job& job : selected.jobs) {
    if (Status status = remove_file(job.record); !status)
      return status.error();
  }
  for (const StudyRow& row : study.rows) {
    const bool runs = std::any_of(selected.jobs.begin(), selected.jobs.end(),
                                  [&](const Job& job) { return job.variant == row.variant.id(); });
    if (runs && (request.timed || selection == StudySelection::all)) {
      if (Status status = throw_away(request, row); !status)
        return status.error();
    }
    if (request.stages != StudyStages::draw)
      continue;
    if (Status status = link_frames(request, row); !status)
      return status.error();
  }
  if (Status status = engine.run(selected, settings); !status)
    return status.error();
  return read_study(request);
}

} // namespace wry::pipeline
