#include <algorithm>
#include <filesystem>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/cli/expectations.h"
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

/// What an expectation is about in a wedge: its measure on its frame; NaN when it is not there.
double measured_in(const StudyRow& row, const shots::Expectation& expectation, int frame) {
  const CsvTable table = read_csv_table(row.folder / "measure.csv");
  const std::vector<double> frames = table.numbers("frame"), values = table.numbers(*expectation.measure);
  const std::size_t known = std::min(frames.size(), values.size());
  for (std::size_t i = 0; i < known; ++i) {
    if (frames[i] == frame)
      return values[i];
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// The ratios of one expectation. Without a case every other wedge must hold it. Adds what does not hold.
void judge_ratios(const shots::Expectation& expectation, int frame, const std::vector<StudyRow>& rows,
                  std::string& failed) {
  const auto base = std::find_if(rows.begin(), rows.end(),
                                 [&](const StudyRow& row) { return row.variant.name == **expectation.ratio_to; });
  const double divisor =
      base == rows.end() ? std::numeric_limits<double>::quiet_NaN() : measured_in(*base, expectation, frame);
  bool seen = false;
  for (const StudyRow& row : rows) {
    const bool meant = expectation.sweep_case ? row.variant.name == **expectation.sweep_case
                                              : row.variant.name != **expectation.ratio_to;
    if (!meant)
      continue;
    seen = true;
    const double ratio = measured_in(row, expectation, frame) / divisor;
    if ((expectation.min && !(ratio >= **expectation.min)) || (expectation.max && !(ratio <= **expectation.max)))
      failed += fmt::format("\n  {}: {} of {} over {} is {:.4g} at frame {}", expectation.source.text(),
                            *expectation.measure, row.variant.name, **expectation.ratio_to, ratio, frame);
  }
  if (!seen)
    failed +=
        fmt::format("\n  {}: there is no wedge to divide by {}", expectation.source.text(), **expectation.ratio_to);
}

/// Ratios between wedges, which no single wedge can hold against its expectation. What is about a frame that was not
/// asked for is not judged.
Status check_ratios(const ShotSession& session, const std::vector<StudyRow>& rows) {
  std::string failed;
  for (const shots::Expectation& expectation : session.shot.expectations) {
    if (!expectation.ratio_to)
      continue;
    // All frames up to the last are made, whichever are drawn.
    const int frame = expected_frame(expectation, session.shot);
    if (frame > session.frames.back())
      fmt::print("not judged: {} ({})\n", *expectation.name, not_asked_for(frame));
    else
      judge_ratios(expectation, frame, rows, failed);
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
  // A wedge that does not hold what is expected of it is measured all the same.
  const bool measured = std::all_of(study->rows.begin(), study->rows.end(), [](const StudyRow& row) {
    return row.outcome == StudyOutcome::done || row.outcome == StudyOutcome::expectation_failed;
  });
  const Status ratios = measured ? check_ratios(*session, study->rows) : Status();
  if (bad > 0)
    return make_error(ErrorCode::check_failed, "{} of {} wedges are not done:\n{}{}", bad, study->rows.size(),
                      study_failures(study->rows), ratios ? std::string() : ratios.error().message);
  return ratios;
}

} // namespace wry::pipeline
