#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "pipeline/run/engines/job.h"

namespace wry::pipeline {

/// Where a job of a graph stands.
enum class JobPhase {
  waiting, ///< for others, or for room
  running,
  done,    ///< exit code 0
  failed,  ///< any other, but 75
  stopped, ///< 75: goes on from its checkpoint
  skipped, ///< one that it depends on failed
};

struct JobState {
  const Job* job = nullptr;
  JobPhase phase = JobPhase::waiting;
  int percent = -1; ///< of a running job, as far as it says
};

/// Called when something changed, for the live status.
using EngineObserver = std::function<void(std::span<const JobState>)>;

struct EngineSettings {
  int jobs = 1; ///< processes at a time
  EngineObserver observer;
};

/// Where jobs run. Another farm is one .cpp with one of these, and a line in the table.
class Engine {
public:
  virtual ~Engine() = default;

  /// Runs every job of the graph after those it depends on, and returns when all have ended or cannot begin. What came
  /// of each is in its record: an engine's own idea of success does not count. Errors: unavailable when this engine is
  /// not on this machine; stopped after a stop signal, when the jobs have been told; cannot_write, io.
  virtual Status run(const JobGraph& graph, const EngineSettings& settings) = 0;
};

struct EngineKind {
  std::string_view name;
  std::string_view doc;
  std::unique_ptr<Engine> (*make)();
};

/// Every engine of this build, the default first.
std::span<const EngineKind> engine_kinds();

/// Errors: usage, naming those that there are.
Result<std::unique_ptr<Engine>> make_engine(std::string_view name);

std::unique_ptr<Engine> make_local_engine();
std::unique_ptr<Engine> make_slurm_engine();

} // namespace wry::pipeline
