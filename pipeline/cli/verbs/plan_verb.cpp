#include <cstdio>
#include <filesystem>

#include "pipeline/cli/shot_session.h"
#include "pipeline/cli/verb.h"
#include "pipeline/plan/cost.h"
#include "pipeline/plan/plan_report.h"
#include "pipeline/plan/savings.h"
#include "pipeline/run/resources.h"

namespace wry::pipeline {

namespace {

/// Whether a run would find room for it here.
Status look_for_room(const ShotSession& session, const ScenePlan& plan) {
  std::filesystem::path folder = std::filesystem::absolute(session.out);
  while (!std::filesystem::exists(folder) && folder.has_relative_path())
    folder = folder.parent_path();
  const Result<Machine> machine = read_machine(folder);
  const double frame_count = plan.sim.last_frame - plan.sim.first_frame + 1;
  return machine ? require_resources(plan.name, plan.cost, frame_count, *machine) : Status(machine.error());
}

} // namespace

Status plan_verb(const Invocation& invocation) {
  const Result<ShotSession> session = open_session(invocation);
  if (!session)
    return session.error();
  Result<ScenePlan> plan = plan_session(*session);
  if (!plan)
    return plan.error();
  if (Status status = describe_solver(*plan, session->isa, invocation.threads); !status)
    return status;
  describe_savings(session->shot, *plan, session->isa, invocation.threads);
  if (Status room = look_for_room(*session, *plan); !room)
    plan->warnings.push_back("as it stands it would be refused: " + room.error().message);
  const std::string report = invocation.json ? plan_json(*plan) + "\n" : plan_text(*plan);
  std::fputs(report.c_str(), stdout);
  return {};
}

} // namespace wry::pipeline
