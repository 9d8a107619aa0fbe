#include <algorithm>
#include <filesystem>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/cli/output_folder.h"
#include "pipeline/cli/study_session.h"
#include "pipeline/cli/verb.h"
#include "pipeline/report/csv_table.h"
#include "pipeline/study/study_page.h"
#include "pipeline/study/study_pictures.h"
#include "pipeline/study/study_table.h"
#include "shots/load.h"
#include "shots/sweep.h"

namespace wry::pipeline {

namespace {

/// Ratios between wedges, which no single wedge can hold against its expectation.
Status check_ratios(const shots::Shot& shot, const std::vector<StudyRow>& rows) {
  std::string failed;
  const auto value_in = [&](const std::string& wedge, const std::string& measure) {
    for (const StudyRow& row : rows) {
      if (row.variant.name != wedge)
        continue;
      if (const std::string* value = find_measure(row, measure))
        return number_of(*value);
    }
    return std::numeric_limits<double>::quiet_NaN();
  };
  for (const shots::Expectation& expectation : shot.expectations) {
    if (!expectation.ratio_to || !expectation.sweep_case)
      continue;
    const double ratio = value_in(**expectation.sweep_case, *expectation.measure) /
                         value_in(**expectation.ratio_to, *expectation.measure);
    if ((expectation.min && !(ratio >= **expectation.min)) || (expectation.max && !(ratio <= **expectation.max)))
      failed += fmt::format("\n  {}: {} of {} over {} is {:.4g}", expectation.source.text(), *expectation.measure,
                            **expectation.sweep_case, **expectation.ratio_to, ratio);
  }
  if (!failed.empty())
    return make_error(ErrorCode::check_failed, "expectations between wedges that do not hold:{}", failed);
  return {};
}

/// The wedges of [sweep], numbered.
Result<std::vector<Variant>> wedges_of(const std::string& shot, const std::filesystem::path& folder) {
  const Result<shots::ShotDocument> document = shots::read_document(shot);
  if (!document)
    return document.error();
  const Result<std::vector<shots::Wedge>> wedges = shots::expand_sweep(*document);
  if (!wedges)
    return wedges.error();
  if (wedges->empty())
    return make_error(ErrorCode::bad_input,
                      "{} has no [sweep]; add lists of values, such as \"material.skin.length_scale\" = [0, 0.1, 1]",
                      shot);
  std::vector<Variant> variants;
  for (const shots::Wedge& wedge : *wedges)
    variants.push_back(variant_of(wedge));
  if (Status status = number_variants(variants, folder); !status)
    return status.error();
  return variants;
}

/// The command that a farm runs last.
std::vector<std::string> collecting_command(const Invocation& invocation, const std::filesystem::path& folder) {
  std::vector<std::string> words = {"sweep", invocation.subject, "--collect", "--out", folder.string()};
  for (const std::string& text : invocation.sets)
    words.insert(words.end(), {"--set", text});
  if (!invocation.frames.empty())
    words.insert(words.end(), {"--frames", invocation.frames});
  words.insert(words.end(), {"--isa", invocation.isa, "--gl", invocation.gl, "--quiet"});
  return words;
}

/// Table, sheet, mosaic and page from what is there.
Status write_sweep(const ShotSession& session, const StudyRequest& request, const std::vector<StudyRow>& rows,
                   const Invocation& invocation) {
  const std::filesystem::path table = request.folder / "sweep.csv";
  if (Status status = write_file_atomically(table, study_csv(rows)); !status)
    return status;
  const Result<StudyPictures> pictures = make_study_pictures(request.folder, rows);
  if (!pictures)
    return pictures.error();
  if (Status status = write_study_page(request.folder, *session.shot.shot.name, rows, *pictures); !status)
    return status;
  if (!invocation.quiet) {
    fmt::print("{}\ntable: {}\n", study_summary(rows), table.string());
    if (!pictures->sheet.empty())
      fmt::print("sheet: {}\n", (request.folder / pictures->sheet).string());
    if (!pictures->mosaic.empty())
      fmt::print("film:  {}\n", (request.folder / pictures->mosaic).string());
    fmt::print("page:  {}\n", (request.folder / "index.html").string());
  }
  return {};
}

} // namespace

Status sweep_verb(const Invocation& invocation) {
  const Result<ShotSession> session = open_session(invocation);
  if (!session)
    return session.error();
  StudyRequest request = study_request(*session, invocation);
  Result<std::vector<Variant>> wedges = wedges_of(invocation.subject, request.folder);
  if (!wedges)
    return wedges.error();
  request.variants = std::move(*wedges);
  request.collect = collecting_command(invocation, request.folder);
  Result<Study> study = read_study(request);
  if (!study)
    return study.error();
  if (invocation.list || invocation.dry_run) {
    print_job_graph(*study, invocation);
    return {};
  }
  std::optional<FolderLock> held;
  if (!invocation.collect) {
    // A farm's last job collects while the sweep that sent it still waits: only the one that sends jobs locks.
    Result<FolderLock> lock = take_folder(request.folder);
    if (!lock)
      return lock.error();
    held.emplace(std::move(*lock));
    if (invocation.engine == "local") // what waits for the jobs collects, too
      std::erase_if(study->graph.jobs, [](const Job& job) { return job.variant.empty(); });
    study = run_study_session(request, *study, invocation);
    if (!study)
      return study.error();
  }
  if (Status status = write_sweep(*session, request, study->rows, invocation); !status)
    return status;
  const auto bad = std::count_if(study->rows.begin(), study->rows.end(),
                                 [](const StudyRow& row) { return row.outcome != StudyOutcome::done; });
  if (bad > 0)
    return make_error(ErrorCode::check_failed, "{} of {} wedges are not done:\n{}", bad, study->rows.size(),
                      study_failures(study->rows));
  return check_ratios(session->shot, study->rows);
}

} // namespace wry::pipeline
