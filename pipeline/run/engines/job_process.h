#pragma once

#include <chrono>
#include <memory>
#include <optional>

#include <sys/types.h>

#include "pipeline/run/engines/job.h"

namespace wry::pipeline {

/// A job that runs as a child of this process: its own process group, its output in its log, its resources measured.
class JobProcess {
public:
  /// Errors: unavailable when no process can be started; cannot_write for the log.
  static Result<JobProcess> start(const Job& job);

  /// The record once the process has ended, written to its place too; nothing while it runs. Ends the process when it
  /// is beyond its time. Errors: cannot_write, io for the record.
  Result<std::optional<JobRecord>> poll();

  /// Asks the process to stop where it can be resumed.
  void ask_to_stop();

  const Job& job() const { return *m_job; }
  /// How far it is by its own words, 0 to 100; negative when it has not said.
  int percent() const;

private:
  JobProcess(const Job& job, pid_t child);
  const Job* m_job;
  pid_t m_child;
  std::chrono::steady_clock::time_point m_start;
  double m_asked_at = 0.0; ///< [s] since the start
  bool m_timed_out = false;
  bool m_killed = false;
};

/// Runs a job to its end as `wry job` does on a farm; a stop signal is passed on. Errors: as start() and poll().
Result<JobRecord> run_job(const Job& job);

/// Last lines of a log that say why a process failed, shortened for a table.
std::string last_words(const std::filesystem::path& log);

/// The program that runs now, absolute.
std::string this_program();

/// Has programs that this one starts from now on know whose children they are, for follow_parent().
void announce_parent();
/// Called first in a program that JobProcess started: has the system end it when its parent dies.
void follow_parent();

} // namespace wry::pipeline
