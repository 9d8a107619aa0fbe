#include <cstdio>

#include <fmt/format.h>

#include "pipeline/cli/expectations.h"
#include "pipeline/cli/output_folder.h"
#include "pipeline/cli/run_report.h"
#include "pipeline/cli/shot_run.h"
#include "pipeline/cli/verb.h"
#include "pipeline/plan/plan_report.h"

namespace wry::pipeline {

Status run_verb(const Invocation& invocation) {
  const Result<ShotSession> session = open_session(invocation);
  if (!session)
    return session.error();
  const Result<ScenePlan> plan = plan_session(*session);
  if (!plan)
    return plan.error();
  if (!invocation.quiet || invocation.dry_run)
    std::fputs(plan_text(*plan).c_str(), stdout);
  if (invocation.dry_run)
    return {};
  std::fflush(stdout);
  const Result<FolderLock> lock = take_folder(session->out);
  if (!lock)
    return lock.error();
  const Result<MeasureTable> table = simulate_session(*session, *plan, invocation);
  if (!table)
    return table.error();
  if (Status status = draw_session(*session, invocation); !status)
    return status;
  if (Status status = encode_session(*session); !status)
    return status;
  if (Status status = write_run_report(*session, *plan); !status)
    return status;
  if (!invocation.quiet)
    fmt::print("pictures: {}\nreport:   {}\n", (session->out / "images").string(),
               (session->out / "report.html").string());
  return report_judgements(judge_expectations(session->shot, *table));
}

} // namespace wry::pipeline
