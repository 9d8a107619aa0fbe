#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/run/engines/engine.h"
#include "pipeline/run/resources.h"
#include "pipeline/study/variant.h"
#include "shots/shot.h"
#include "sim/base/isa.h"

namespace wry::pipeline {

/// What every variant of a study goes through.
enum class StudyStages {
  simulate, ///< frames and measures only
  draw,     ///< render frames that are there: those of the folder that `frames_of` names
  pictures, ///< simulate, render in chunks of frames, then `run`, which finds all done, encodes and checks
};

/// A study: variants of one shot, each run whole and isolated in its own processes and its own folder, then read as a
/// table. Sweep, accuracy and stress are readers of it.
struct StudyRequest {
  std::string shot;             ///< the shot file, as the user named it
  std::filesystem::path folder; ///< of the study, absolute
  std::string part = "wedges";  ///< name of the folder below it that holds the variants' folders
  std::vector<Variant> variants;
  std::vector<std::string> sets; ///< --set of the user, below those of the variants
  std::string frames;            ///< --frames; empty: the shot's
  Isa isa = Isa::sse4;
  std::string gl = "auto";
  int threads = 1; ///< of each process
  StudyStages stages = StudyStages::pictures;
  int frames_per_job = 0; ///< of a rendering job; 0: all
  Shortage shortage = Shortage::refuse;
  double time_limit_seconds = 0.0;   ///< of each simulation; 0: none
  bool failures_are_results = false; ///< as of a stress test: what failed is not run again unless it is asked for
  bool timed = false;                ///< times are results: a variant that was interrupted is run anew, not resumed
  int repeats = 1;                   ///< how often each simulation or drawing is run, for its time
  std::filesystem::path frames_of;   ///< with StudyStages::draw: the folder of a run whose frames all variants draw
  /// Command line of a last job that collects the table, for farms; empty: none.
  std::vector<std::string> collect;
};

/// What came of a variant.
enum class StudyOutcome {
  done,
  expectation_failed, ///< finished, but [expect] does not hold
  failed,
  stopped, ///< on the way; the same command goes on
  not_run,
};
std::string_view outcome_name(StudyOutcome outcome);
/// Whether there is nothing left to do for it.
bool is_finished(StudyOutcome outcome);

/// A variant, its shot, and what is known of its run.
struct StudyRow {
  Variant variant;
  std::filesystem::path folder;
  std::optional<shots::Shot> shot; ///< nothing: it does not load, see reason
  std::vector<int> frames;         ///< that are asked for
  StudyOutcome outcome = StudyOutcome::not_run;
  int exit_code = 0;
  bool timed_out = false;
  std::string reason;                           ///< why it failed, in the words of the process
  double wall_seconds = 0.0, cpu_seconds = 0.0; ///< of all its jobs; with repeats, the median
  double timing_spread = 0.0;                   ///< of repeats: largest CPU time less the least, over the median
  std::uint64_t peak_bytes = 0;
  std::vector<std::pair<std::string, std::string>> measures; ///< last row of measure.csv, by column
};

/// A study as it stands on disk.
struct Study {
  std::vector<StudyRow> rows;
  JobGraph graph;                    ///< every job, those that are done too
  bool failures_are_results = false; ///< as in the request
};

/// Loads every variant's shot, lays out the jobs, and reads what is there: records of jobs whose inputs are still the
/// same, each believed only when the manifest of its frames agrees. Variants must be numbered. Errors: bad_input for
/// the shot itself; io. A variant that does not load is a failed row.
Result<Study> read_study(const StudyRequest& request);

/// Which variants run.
enum class StudySelection {
  unfinished, ///< all that are neither done nor finished with a failed expectation
  only_failed,
  all, ///< their frames are thrown away first
};

/// Runs what is selected of a study, then reads it again. Errors: as Engine::run.
Result<Study> run_study(const StudyRequest& request, const Study& study, Engine& engine, const EngineSettings& settings,
                        StudySelection selection);

/// The jobs of a graph that a selection needs. Jobs that are not among them count as done.
JobGraph select_jobs(const Study& study, StudySelection selection);

} // namespace wry::pipeline
