#pragma once

#include "pipeline/cli/shot_session.h"

namespace wry::pipeline {

/// Writes report.html into the run's folder: summary, plan with what was left out, warnings, pictures, plots. It is
/// read from the folder, so it tells of all the runs that filled it. Errors: cannot_write, io.
Status write_run_report(const ShotSession& session, const ScenePlan& plan);

} // namespace wry::pipeline
