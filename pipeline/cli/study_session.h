#pragma once

#include "pipeline/cli/shot_session.h"
#include "pipeline/study/study.h"

namespace wry::pipeline {

/// What the command line says about a study of this shot; variants are still to be given.
StudyRequest study_request(const ShotSession& session, const Invocation& invocation);

/// Runs what is selected of a study on --engine, with a live status; the caller holds the lock of its folder. Errors:
/// as run_study().
Result<Study> run_study_session(const StudyRequest& request, const Study& study, const Invocation& invocation);

/// Prints the jobs of a study, for people or (--json) for farms that we do not know.
void print_job_graph(const Study& study, const Invocation& invocation);

} // namespace wry::pipeline
