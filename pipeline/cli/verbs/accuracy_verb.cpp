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
#include "pipeline/study/study_table.h"
#include "shots/ladders.h"

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

Status write_page(const ShotSession& session, const StudyRequest& request, const AccuracyReport& report,
                  const std::vector<Plot>& plots) {
  HtmlPage page(*session.shot.shot.name + ": error against run time");
  page.section("Recommendation");
  for (const std::string& advice : report.advice)
    page.paragraph(advice);
  page.section("Plots");
  for (const Plot& plot : plots)
    page.plot(plot);
  page.section("Rungs");
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
  page.section("Observed orders and remarks");
  std::vector<std::pair<std::string, std::string>> facts;
  for (const LadderVerdict& verdict : report.verdicts) {
    facts.emplace_back(verdict.quantity + " over " + verdict.key,
                       verdict.observed_order == verdict.observed_order
                           ? fmt::format("order {:.2f}", verdict.observed_order)
                           : std::string("no order"));
    for (const std::string& remark : verdict.remarks)
      facts.emplace_back("", remark);
  }
  facts.emplace_back("made by", fmt::format("wry {} accuracy {}, {}", version(), request.shot, machine_name()));
  page.facts(facts);
  return write_file_atomically(request.folder / "index.html", page.finish());
}

Status write_accuracy(const ShotSession& session, const StudyRequest& request, const shots::AccuracySection& section,
                      const AccuracyReport& report) {
  if (Status status = write_file_atomically(request.folder / "accuracy.csv", accuracy_csv(report)); !status)
    return status;
  const std::vector<Plot> plots = accuracy_plots(section, report);
  for (std::size_t i = 0; i < plots.size(); ++i) {
    if (Status status = write_plot((request.folder / fmt::format("plot-{:02}", i)).string(), plots[i]); !status)
      return status;
  }
  return write_page(session, request, report, plots);
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

} // namespace

Status accuracy_verb(const Invocation& invocation) {
  const Result<ShotSession> session = open_session(invocation);
  if (!session)
    return session.error();
  const Result<shots::AccuracySection> section = section_of(*session, invocation);
  if (!section)
    return section.error();
  Result<AccuracyStudy> plan = plan_accuracy_study(*section);
  if (!plan)
    return plan.error();
  StudyRequest request = study_request(*session, invocation);
  request.folder /= "accuracy";
  request.part = "rungs";
  const Result<std::optional<HeldStudy>> held = hold_study(request, plan->variants, section->frames, invocation);
  if (!held)
    return held.error();
  if (!*held)
    return {};
  const std::vector<StudyRow>& rows = (*held)->study.rows;
  const AccuracyReport report = judge_accuracy(*section, *plan, rows);
  if (Status status = write_accuracy(*session, request, *section, report); !status)
    return status;
  if (!invocation.quiet)
    fmt::print("{}\n{}page: {}\n", rung_table(report), remarks_text(report), (request.folder / "index.html").string());
  if (const std::string failures = study_failures(rows); !failures.empty())
    return make_error(ErrorCode::check_failed, "rungs that could not be run:\n{}", failures);
  return {};
}

} // namespace wry::pipeline
