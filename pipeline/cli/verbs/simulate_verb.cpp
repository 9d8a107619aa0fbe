#include <cstdio>

#include <fmt/format.h>

#include "pipeline/cli/output_folder.h"
#include "pipeline/cli/shot_run.h"
#include "pipeline/cli/verb.h"
#include "pipeline/plan/plan_report.h"

namespace wry::pipeline {

Status simulate_verb(const Invocation& invocation) {
  const Result<ShotSession> session = open_session(invocation);
  if (!session)
    return session.error();
  const Result<ScenePlan> plan = plan_session(*session);
  if (!plan)
    return plan.error();
  if (invocation.dry_run) {
    std::fputs(plan_text(*plan).c_str(), stdout);
    return {};
  }
  const Result<FolderLock> lock = take_folder(session->out);
  if (!lock)
    return lock.error();
  const Result<MeasureTable> table = simulate_session(*session, *plan, invocation);
  return table ? Status() : Status(table.error());
}

} // namespace wry::pipeline
