#include <fmt/format.h>

#include "pipeline/cli/verb.h"
#include "pipeline/run/engines/job_process.h"

namespace wry::pipeline {

namespace {

const Job* find_task(const JobGraph& graph, const std::string& stage, int task) {
  for (const Job& job : graph.jobs) {
    if (job.stage == stage && job.index == task)
      return &job;
  }
  return nullptr;
}

/// What keeps a job from beginning: a farm may say that something was done which never ran.
std::string missing_before(const JobGraph& graph, const Job& job) {
  for (const std::string& id : job.after) {
    const Job* before = graph.find(id);
    if (before == nullptr || job.after_what == Job::After::any)
      continue;
    const Result<JobRecord> record = read_job_record(*before);
    if (!record)
      return fmt::format("{} left no record: it never ran, or its node could not write", id);
    if (record->exit_code != 0)
      return fmt::format("{} ended with {}", id, record->exit_code);
  }
  return {};
}

} // namespace

Status job_verb(const Invocation& invocation) {
  const Result<JobGraph> graph = read_job_graph(invocation.subject);
  if (!graph)
    return graph.error();
  const Job* job = find_task(*graph, invocation.stage, invocation.task);
  if (job == nullptr)
    return make_error(ErrorCode::usage, "{} has no task {} of stage '{}'", invocation.subject, invocation.task,
                      invocation.stage);
  if (const std::string missing = missing_before(*graph, *job); !missing.empty())
    return make_error(ErrorCode::missing_input, "{}: {}", job->id, missing);
  const Result<JobRecord> record = run_job(*job);
  if (!record)
    return record.error();
  if (record->exit_code == 0)
    return {};
  const bool killed = record->exit_code > 128;
  return make_error(killed ? ErrorCode::io : static_cast<ErrorCode>(record->exit_code), "{}: {}", job->id,
                    record->reason);
}

} // namespace wry::pipeline
