#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/cli/verb.h"
#include "pipeline/plan/scene_plan.h"
#include "shots/load.h"
#include "shots/shot.h"

namespace wry::pipeline {

/// A shot as the command line names it, and where its output goes.
struct ShotSession {
  shots::Shot shot;
  std::filesystem::path out;
  std::vector<int> frames; ///< --frames, or those of the shot
  Isa isa = Isa::sse4;
  std::string shared; ///< --shared
};

/// Loads the shot with --set and --case. Errors: usage, bad_input, missing_input, unavailable (--isa).
Result<ShotSession> open_session(const Invocation& invocation);

/// The shot file with --set and --case in place, for sections that are read by themselves, [accuracy] and [stress].
/// Errors: usage, bad_input, missing_input.
Result<shots::ShotDocument> open_document(const Invocation& invocation);

/// The scene of a session. Errors: as compile_scene().
Result<ScenePlan> plan_session(const ShotSession& session);

/// Starts this program again with other arguments, e.g. one rendering process per core.
struct ChildOutcome {
  int exit_code = 0; ///< 128 + signal when it was killed
};
/// Runs all command lines at the same time and waits; a stop signal is passed on to them. Errors: unavailable when a
/// process cannot be started.
Result<std::vector<ChildOutcome>> run_self(const std::vector<std::vector<std::string>>& command_lines);

/// run_self(), where the first process that failed is the error: its own words are on stderr already.
Status run_self_to_success(const std::vector<std::vector<std::string>>& command_lines);

/// How many rendering processes to start for so many pictures.
int rendering_processes(const Invocation& invocation, std::size_t pictures);

} // namespace wry::pipeline
