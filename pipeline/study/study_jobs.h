#pragma once

#include <string>
#include <vector>

#include "pipeline/study/study.h"

namespace wry::pipeline {

/// The jobs of one variant, in the order in which they depend on each other. Errors: io for an asset that cannot be
/// read; one that is missing is left for the simulation to name.
Result<std::vector<Job>> jobs_of(const StudyRequest& request, const StudyRow& row);

/// Stage, and folder below the variant's, of a repeat that is run for its time alone; repeats count from 1.
std::string timing_stage(int repeat);

/// The job that collects the table when all others have ended.
Job collecting_job(const StudyRequest& request, const JobGraph& graph);

} // namespace wry::pipeline
