#include <cstdio>

#include "pipeline/cli/shot_session.h"
#include "pipeline/cli/verb.h"
#include "pipeline/plan/cost.h"
#include "pipeline/plan/plan_report.h"

namespace wry::pipeline {

Status plan_verb(const Invocation& invocation) {
  const Result<ShotSession> session = open_session(invocation);
  if (!session)
    return session.error();
  Result<ScenePlan> plan = plan_session(*session);
  if (!plan)
    return plan.error();
  if (Status status = describe_solver(*plan, session->isa, invocation.threads); !status)
    return status;
  const std::string report = invocation.json ? plan_json(*plan) + "\n" : plan_text(*plan);
  std::fputs(report.c_str(), stdout);
  return {};
}

} // namespace wry::pipeline
