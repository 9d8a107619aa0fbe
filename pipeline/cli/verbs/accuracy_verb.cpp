#include <algorithm>

#include <fmt/format.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/cli/output_folder.h"
#include "pipeline/cli/study_session.h"
#include "pipeline/cli/verb.h"
#include "pipeline/plan/build_id.h"
#include "pipeline/report/html.h"
#include "pipeline/report/readable.h"
#include "pipeline/study/accuracy.h"
#include "pipeline/study/study_jobs.h"
#include "pipeline/study/study_table.h"
#include "shots/ladders.h"
#include "shots/resolved.h"

namespace wry::pipeline {

namespace {

std::string percent(double value) {
  return value == value ? fmt::format("{:.3g} %", 100.0 * value) : std::string("-");
}

std::string rung_table(const AccuracyReport& report) {
  std::size_t width = 4;
  for (const JudgedRung& rung : report.rungs)
    width = std::max(width, rung.name.size());
  std::string text = fmt::format("{:<{}}  {:>9}", "rung", width, "CPU [s]");
  for (const std::string& quantity : report.quantities)
    text += fmt::format("  {:>12}", quantity.substr(0, 12));
  text += "\n";
  for (const JudgedRung& rung : report.rungs) {
    text += fmt::format("{:<{}}  {:>9.3f}", rung.name, width, rung.cpu_seconds);
    for (const ErrorValue& error : rung.errors)
      text += fmt::format("  {:>12}", percent(error.error));
    text += rung.outcome == "done" ? "\n" : "  " + rung.outcome + "\n";
  }
  return text;
}

std::string remarks_text(const AccuracyReport& report) {
  std::string text;
  for (const LadderVerdict& verdict : report.verdicts) {
    if (verdict.observed_order == verdict.observed_order)
      text += fmt::format("{} over {}: observed order {:.2f}\n", verdict.quantity, verdict.key, verdict.observed_order);
    for (const std::string& remark : verdict.remarks)
      text += fmt::format("{} over {}: {}\n", verdict.quantity, verdict.key, remark);
  }
  for (const std::string& advice : report.advice)
    text += advice + "\n";
  return text;
}

/// One of the two studies behind a report: of simulations, or of pictures.
struct JudgedStudy {
  const char* table; ///< the file
  shots::AccuracySection section;
  AccuracyReport report;
  std::vector<Plot> plots;
};

void add_rungs(const JudgedStudy& study, HtmlPage& page) {
  const AccuracyReport& report = study.report;
  std::vector<std::string> columns = {"rung", "CPU [s]", "wall [s]", "steps", "Newton iterations"};
  columns.insert(columns.end(), report.quantities.begin(), report.quantities.end());
  columns.emplace_back("outcome");
  std::vector<std::vector<std::string>> rows;
  for (const JudgedRung& rung : report.rungs) {
    std::vector<std::string> row = {rung.name, fmt::format("{:.3f}", rung.cpu_seconds),
                                    fmt::format("{:.3f}", rung.wall_seconds), fmt::format("{:g}", rung.steps),
                                    fmt::format("{:g}", rung.iterations)};
    for (const ErrorValue& error : rung.errors)
      row.push_back(percent(error.error));
    row.push_back(rung.outcome);
    rows.push_back(std::move(row));
  }
  page.table(columns, rows);
}

void add_remarks(const JudgedStudy& study, std::vector<std::pair<std::string, std::string>>& facts) {
  for (const LadderVerdict& verdict : study.report.verdicts) {
    facts.emplace_back(verdict.quantity + " over " + verdict.key,
                       verdict.observed_order == verdict.observed_order
                           ? fmt::format("order {:.2f}", verdict.observed_order)
                           : std::string("no order"));
    for (const std::string& remark : verdict.remarks)
      facts.emplace_back("", remark);
  }
}

Status write_page(const ShotSession& session, const StudyRequest& request, const std::vector<JudgedStudy>& studies) {
  HtmlPage page(*session.shot.shot.name + ": error against run time");
  page.section("Recommendation");
  for (const JudgedStudy& study : studies) {
    for (const std::string& advice : study.report.advice)
      page.paragraph(advice);
  }
  page.section("Plots");
  for (const JudgedStudy& study : studies) {
    for (const Plot& plot : study.plots)
      page.plot(plot);
  }
  page.section("Rungs");
  std::vector<std::pair<std::string, std::string>> facts;
  for (const JudgedStudy& study : studies) {
    add_rungs(study, page);
    add_remarks(study, facts);
  }
  page.section("Observed orders and remarks");
  facts.emplace_back("times", request.repeats > 1 ? fmt::format("the median of {} runs each", request.repeats)
                                                  : std::string("of one run each; accuracy.repeats asks for more"));
  facts.emplace_back("made by", fmt::format("wry {} accuracy {}, {}", version(), request.shot, machine_name()));
  page.facts(facts);
  return write_file_atomically(request.folder / "index.html", page.finish());
}

Status write_accuracy(const ShotSession& session, const StudyRequest& request,
                      const std::vector<JudgedStudy>& studies) {
  int number = 0;
  for (const JudgedStudy& study : studies) {
    if (Status status = write_file_atomically(request.folder / study.table, accuracy_csv(study.report)); !status)
      return status;
    for (const Plot& plot : study.plots) {
      if (Status status = write_plot((request.folder / fmt::format("plot-{:02}", number++)).string(), plot); !status)
        return status;
    }
  }
  return write_page(session, request, studies);
}

/// Particles are in single precision by default: without ladders of the shot's own, that against double precision.
Result<shots::AccuracySection> section_of(const ShotSession& session, const Invocation& invocation) {
  const Result<shots::ShotDocument> document = open_document(invocation);
  if (!document)
    return document.error();
  Result<shots::AccuracySection> section = shots::read_accuracy(*document);
  if (!section || !section->ladders.empty())
    return section;
  const bool has_particles = std::any_of(session.shot.bodies.begin(), session.shot.bodies.end(),
                                         [&](const shots::Body& body) { return session.shot.is_particles(body); });
  if (!has_particles)
    return make_error(ErrorCode::bad_input,
                      "{} has no ladder in [accuracy]; add one, such as \"fem.time_step\" = [0.02, 0.01, 0.005]",
                      invocation.subject);
  section->ladders.push_back({"mpm.precision", {}, {"\"f32\""}});
  section->reference.push_back({"mpm.precision", "\"f64\"", {}});
  return section;
}

JudgedStudy judged(const char* table, const shots::AccuracySection& section, const AccuracyStudy& plan,
                   const std::vector<StudyRow>& rows, Compared compared) {
  JudgedStudy study{table, section, judge_accuracy(section, plan, rows, compared), {}};
  study.plots = accuracy_plots(section, study.report);
  return study;
}

/// Repeats were run for their time: what they made is the same once more.
void remove_repeats(const StudyRequest& request, const std::vector<StudyRow>& rows) {
  for (const StudyRow& row : rows) {
    std::error_code ignored;
    for (int repeat = 1; repeat < request.repeats && is_finished(row.outcome); ++repeat)
      std::filesystem::remove_all(row.folder / timing_stage(repeat), ignored);
  }
}

/// Draws the frames of `base` once for each rung, and judges the pictures. Nothing where only the list is asked for.
Result<std::optional<JudgedStudy>> judge_pictures(StudyRequest request, const shots::AccuracySection& section,
                                                  const HasValue& has, const std::filesystem::path& base,
                                                  const Invocation& invocation, std::string& failures) {
  Result<AccuracyStudy> plan = plan_accuracy_study(section, has);
  if (!plan)
    return plan.error();
  request.part = "pictures";
  request.stages = StudyStages::draw;
  request.frames_of = base;
  const Result<std::optional<Study>> study = run_held_study(request, plan->variants, invocation);
  if (!study)
    return study.error();
  if (!*study)
    return std::optional<JudgedStudy>();
  remove_repeats(request, (*study)->rows);
  failures += study_failures((*study)->rows);
  return std::optional(judged("pictures.csv", section, *plan, (*study)->rows, Compared::pictures));
}

} // namespace

Status accuracy_verb(const Invocation& invocation) {
  const Result<ShotSession> session = open_session(invocation);
  if (!session)
    return session.error();
  const Result<shots::AccuracySection> section = section_of(*session, invocation);
  if (!section)
    return section.error();
  const SplitLadders ladders = split_ladders(*section);
  const Result<shots::ShotDocument> document = open_document(invocation);
  if (!document)
    return document.error();
  const std::vector<shots::FlatKey> own = shots::flatten(session->shot);
  const HasValue has = [&](const std::string& key, const std::string& value) {
    const Result<shots::ShotDocument> turned = shots::apply_overrides(*document, {{key, value, {}}});
    const Result<shots::Shot> shot = turned ? shots::make_shot(*turned) : turned.error();
    return shot && shots::compare(own, shots::flatten(*shot)).empty();
  };
  Result<AccuracyStudy> plan = plan_accuracy_study(ladders.simulated, has);
  if (!plan)
    return plan.error();
  StudyRequest request = study_request(*session, invocation);
  request.folder /= "accuracy";
  request.part = "rungs";
  request.timed = true;
  request.repeats = section->repeats;
  const Result<std::optional<HeldStudy>> held = hold_study(request, plan->variants, section->frames, invocation);
  if (!held)
    return held.error();
  const bool listed = !*held;
  const std::vector<StudyRow> rows = listed ? std::vector<StudyRow>() : (*held)->study.rows;
  std::vector<JudgedStudy> studies;
  std::string failures = study_failures(rows);
  if (!listed) {
    remove_repeats(request, rows);
    studies.push_back(judged("accuracy.csv", ladders.simulated, *plan, rows, Compared::frames));
  }
  if (!ladders.drawn.ladders.empty()) {
    const std::filesystem::path base =
        listed ? request.folder / request.part / plan->variants[plan->base].id() : rows[plan->base].folder;
    Result<std::optional<JudgedStudy>> pictures =
        judge_pictures(request, ladders.drawn, has, base, invocation, failures);
    if (!pictures)
      return pictures.error();
    if (*pictures)
      studies.push_back(std::move(**pictures));
  }
  if (listed)
    return {};
  if (Status status = write_accuracy(*session, request, studies); !status)
    return status;
  for (const JudgedStudy& study : studies) {
    if (!invocation.quiet && !study.report.rungs.empty())
      fmt::print("{}\n{}\n", rung_table(study.report), remarks_text(study.report));
  }
  if (!invocation.quiet)
    fmt::print("page: {}\n", (request.folder / "index.html").string());
  if (!failures.empty())
    return make_error(ErrorCode::check_failed, "rungs that could not be run:\n{}", failures);
  return {};
}

} // namespace wry::pipeline
