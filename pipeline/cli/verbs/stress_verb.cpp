#include <fmt/format.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/cli/output_folder.h"
#include "pipeline/cli/study_session.h"
#include "pipeline/cli/verb.h"
#include "pipeline/plan/build_id.h"
#include "pipeline/report/html.h"
#include "pipeline/report/readable.h"
#include "pipeline/study/stress.h"
#include "shots/ladders.h"

namespace wry::pipeline {

namespace {

Status write_page(const StressStudy& plan, const std::vector<StudyRow>& rows, const StressReport& report,
                  const std::string& name, const StudyRequest& request) {
  HtmlPage page(name + ": stability");
  page.section("Safe up to");
  for (const std::string& line : report.safe)
    page.paragraph(line);
  page.section("One knob at a time");
  page.svg(map_svg(stress_map(plan, report, name)));
  page.section("Two knobs");
  page.svg(map_svg(stress_pairs_map(plan, report, name)));
  page.section("Refusals and failures");
  std::vector<std::vector<std::string>> table;
  for (std::size_t c = 0; c < plan.cases.size(); ++c) {
    if (!report.findings[c].message.empty())
      table.push_back({rows[plan.cases[c].row].variant.name, report.findings[c].message});
  }
  page.table({"case", "message"}, table);
  page.facts({{"made by", fmt::format("wry {} stress {}, {}", version(), request.shot, machine_name())},
              {"each case", fmt::format("{} s at most", request.time_limit_seconds)}});
  return write_file_atomically(request.folder / "index.html", page.finish());
}

Status write_stress(const StressStudy& plan, const std::vector<StudyRow>& rows, const StressReport& report,
                    const std::string& name, const StudyRequest& request) {
  if (Status status = write_file_atomically(request.folder / "stress.csv", stress_csv(plan, rows, report)); !status)
    return status;
  if (Status status = write_map((request.folder / "map").string(), stress_map(plan, report, name)); !status)
    return status;
  if (Status status = write_map((request.folder / "pairs").string(), stress_pairs_map(plan, report, name)); !status)
    return status;
  return write_page(plan, rows, report, name, request);
}

} // namespace

Status stress_verb(const Invocation& invocation) {
  const Result<ShotSession> session = open_session(invocation);
  if (!session)
    return session.error();
  const Result<shots::ShotDocument> document = open_document(invocation);
  if (!document)
    return document.error();
  const Result<shots::StressSection> section = shots::read_stress(*document);
  if (!section)
    return section.error();
  const AcceptsValue accepts = [&](const std::string& key, const std::string& value) {
    const Result<shots::ShotDocument> turned = shots::apply_overrides(*document, {{key, value, {}}});
    return turned && shots::make_shot(*turned);
  };
  StressStudy plan = plan_stress_study(*section, session->shot, accepts);
  StudyRequest request = study_request(*session, invocation);
  request.folder /= "stress";
  request.part = "cases";
  request.time_limit_seconds = section->time_limit;
  const Result<std::optional<HeldStudy>> held = hold_study(request, plan.variants, section->frames, invocation);
  if (!held)
    return held.error();
  if (!*held)
    return {};
  const std::vector<StudyRow>& rows = (*held)->study.rows;
  const StressReport report = judge_stress(plan, rows);
  if (Status status = write_stress(plan, rows, report, *session->shot.shot.name, request); !status)
    return status;
  if (!invocation.quiet) {
    for (const std::string& line : report.safe)
      fmt::print("{}\n", line);
    fmt::print("table: {}\nmap:   {}\npage:  {}\n", (request.folder / "stress.csv").string(),
               (request.folder / "map.png").string(), (request.folder / "index.html").string());
  }
  if (report.failures > 0)
    return make_error(ErrorCode::check_failed, "{} of {} cases failed ungracefully; see {}", report.failures,
                      plan.cases.size(), (request.folder / "stress.csv").string());
  return {};
}

} // namespace wry::pipeline
