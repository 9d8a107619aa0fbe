#include "pipeline/run/engines/job.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "pipeline/cache/atomic_file.h"

namespace wry::pipeline {

namespace {

using nlohmann::json;

std::string dump(const json& value) {
  return value.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

Job job_of(const json& value) {
  Job job;
  job.id = value.at("id");
  job.stage = value.at("stage");
  job.variant = value.at("variant");
  job.index = value.at("index");
  job.arguments = value.at("command").get<std::vector<std::string>>();
  if (!job.arguments.empty())
    job.arguments.erase(job.arguments.begin()); // the program
  job.after = value.at("after").get<std::vector<std::string>>();
  job.after_what = value.at("after_failure_too").get<bool>() ? Job::After::any : Job::After::success;
  job.record = value.at("record").get<std::string>();
  job.log = value.at("log").get<std::string>();
  job.key = value.at("key");
  job.outputs = value.at("outputs").get<std::vector<std::string>>();
  job.time_limit_seconds = value.at("time_limit_s");
  return job;
}

} // namespace

const Job* JobGraph::find(const std::string& id) const {
  const auto found = std::find_if(jobs.begin(), jobs.end(), [&](const Job& job) { return job.id == id; });
  return found == jobs.end() ? nullptr : &*found;
}

std::string job_graph_json(const JobGraph& graph, const std::string& program) {
  json jobs = json::array();
  for (const Job& job : graph.jobs) {
    std::vector<std::string> command = {program};
    command.insert(command.end(), job.arguments.begin(), job.arguments.end());
    jobs.push_back({{"id", job.id},
                    {"stage", job.stage},
                    {"variant", job.variant},
                    {"index", job.index},
                    {"command", command},
                    {"after", job.after},
                    {"after_failure_too", job.after_what == Job::After::any},
                    {"record", job.record.string()},
                    {"log", job.log.string()},
                    {"key", job.key},
                    {"outputs", job.outputs},
                    {"time_limit_s", job.time_limit_seconds}});
  }
  return dump({{"folder", graph.folder.string()},
               {"resumable_exit_code", static_cast<int>(ErrorCode::stopped)},
               {"jobs", jobs}});
}

Result<JobGraph> read_job_graph(const std::filesystem::path& path) {
  const Result<std::string> text = read_whole_file(path);
  if (!text)
    return text.error();
  try {
    const json value = json::parse(*text);
    JobGraph graph;
    graph.folder = value.at("folder").get<std::string>();
    for (const json& job : value.at("jobs"))
      graph.jobs.push_back(job_of(job));
    return graph;
  } catch (const json::exception& problem) {
    return make_error(ErrorCode::bad_input, "{}: this is no job graph of wry: {}", path.string(), problem.what());
  }
}

Status write_job_record(const Job& job, const JobRecord& record) {
  if (Status status = prepare_folder(job.record.parent_path()); !status)
    return status;
  return write_file_atomically(job.record, dump({{"job", job.id},
                                                 {"exit_code", record.exit_code},
                                                 {"timed_out", record.timed_out},
                                                 {"wall_seconds", record.wall_seconds},
                                                 {"cpu_seconds", record.cpu_seconds},
                                                 {"peak_bytes", record.peak_bytes},
                                                 {"host", record.host},
                                                 {"reason", record.reason},
                                                 {"key", job.key}}));
}

Result<JobRecord> read_job_record(const Job& job) {
  const Result<std::string> text = read_whole_file(job.record);
  if (!text)
    return text.error();
  try {
    const json value = json::parse(*text);
    JobRecord record{value.at("exit_code"),  value.at("timed_out"), value.at("wall_seconds"), value.at("cpu_seconds"),
                     value.at("peak_bytes"), value.at("host"),      value.at("reason"),       value.at("key")};
    if (record.key != job.key)
      return make_error(ErrorCode::missing_input, "{}: this record is of other inputs", job.record.string());
    return record;
  } catch (const json::exception& problem) {
    return make_error(ErrorCode::bad_input, "{}: this is no record of a job: {}", job.record.string(), problem.what());
  }
}

} // namespace wry::pipeline
