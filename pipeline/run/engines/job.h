#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "sim/base/result.h"

namespace wry::pipeline {

/// One process of wry that a study needs: isolated, resumable, and done when its record says so.
struct Job {
  std::string id;                     ///< "003-1f0c9a2b.simulate", one word
  std::string stage;                  ///< "simulate", "render-0", "finish", "sheet": jobs of one stage form an array
  std::string variant;                ///< whose job it is: "003-1f0c9a2b"; empty: of the whole study
  int index = 0;                      ///< of the variant: the task number in an array
  std::vector<std::string> arguments; ///< behind the program's name
  std::vector<std::string> after;     ///< ids of jobs that come first
  enum class After { success, any } after_what = After::success; ///< `any`: runs even when those failed
  std::filesystem::path record;                                  ///< JSON, written when it has ended
  std::filesystem::path log;                                     ///< stdout and stderr
  std::string key;                  ///< hash of all that its outputs depend on: a record with another key is stale
  std::vector<std::string> outputs; ///< files and folders that it makes, for people and other farms
  /// Of CPU, or twice as much by the clock, so that a busy machine changes less; 0: none. Then SIGTERM, and
  /// SIGKILL a little later.
  double time_limit_seconds = 0.0;
};

/// The jobs of a study, each behind those it depends on.
struct JobGraph {
  std::filesystem::path folder; ///< of the study, absolute
  std::vector<Job> jobs;

  const Job* find(const std::string& id) const; ///< nullptr: there is none
};

/// What is known of a job that has ended.
struct JobRecord {
  int exit_code = 0; ///< 128 + signal when it was killed
  bool timed_out = false;
  double wall_seconds = 0.0;
  double cpu_seconds = 0.0;
  std::uint64_t peak_bytes = 0; ///< largest resident size of the process
  std::string host;
  std::string reason; ///< the last words of a process that failed
  std::string key;    ///< of the job that was run
};

/// As JSON: what `wry sweep --list --json` prints and what other machines read.
std::string job_graph_json(const JobGraph& graph, const std::string& program);
/// The inverse. Errors: missing_input, bad_input, io.
Result<JobGraph> read_job_graph(const std::filesystem::path& path);

/// Errors: cannot_write, io.
Status write_job_record(const Job& job, const JobRecord& record);
/// The record of a job with this key. Errors: missing_input when there is none or it is of another key; bad_input.
Result<JobRecord> read_job_record(const Job& job);

/// How often a job is started again by an engine when it was stopped (75) rather than failed.
inline constexpr int MOST_REQUEUES = 20;

} // namespace wry::pipeline
