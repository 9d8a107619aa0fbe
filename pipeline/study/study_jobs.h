#pragma once

#include <vector>

#include "pipeline/study/study.h"

namespace wry::pipeline {

/// The jobs of one variant, in the order in which they depend on each other. Errors: io for an asset that cannot be
/// read; one that is missing is left for the simulation to name.
Result<std::vector<Job>> jobs_of(const StudyRequest& request, const StudyRow& row);

/// The job that collects the table when all others have ended.
Job collecting_job(const StudyRequest& request, const JobGraph& graph);

} // namespace wry::pipeline
