#pragma once

#include <filesystem>
#include <string>

#include "pipeline/plan/scene_plan.h"
#include "pipeline/run/machine.h"
#include "pipeline/run/resources.h"
#include "pipeline/run/step_columns.h"
#include "sim/base/isa.h"

namespace wry::pipeline {

/// How a simulation is run; none of it changes the answer but `isa`.
struct SimulateOptions {
  std::filesystem::path out; ///< the shot's own folder
  int threads = 0;           ///< 0: all cores
  Isa isa = Isa::sse4;
  enum class Start { resume, fresh } start = Start::resume;
  enum class Talk { normal, quiet } talk = Talk::normal;
  Shortage shortage = Shortage::refuse;
  SystemFiles system; ///< where the machine says what is left of memory and disk
};

/// What a simulation did.
struct SimulateOutcome {
  enum class What { all, grains } what = What::all; ///< grains: the matter was there, nothing was simulated
  int frames_written = 0;
  int frames_kept = 0;  ///< were there already, from the same inputs
  int resumed_from = 0; ///< frame of the checkpoint it went on from; 0: it started anew
  StepTotals totals;    ///< of this run's steps
  double wall_seconds = 0.0;
  std::string solver; ///< linear solver and why
};

/// Advances a shot to its last frame, writing frames and checkpoints into its folder; goes on where an earlier run of
/// the same inputs stopped. The caller holds the folder's lock. What is predicted to need more memory or disk than
/// there is does not start (see require_resources). Errors: stopped (a checkpoint was written), solver, cannot_write,
/// io, out_of_memory; the last good frame is then kept.
Result<SimulateOutcome> simulate(const shots::Shot& shot, const ScenePlan& plan, const SimulateOptions& options);

} // namespace wry::pipeline
