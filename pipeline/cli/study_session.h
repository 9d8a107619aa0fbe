#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/cli/shot_session.h"
#include "pipeline/run/lock.h"
#include "pipeline/study/study.h"

namespace wry::pipeline {

/// What the command line says about a study of this shot; variants are still to be given.
StudyRequest study_request(const ShotSession& session, const Invocation& invocation);

/// Runs what is selected of a study on --engine, with a live status; the caller holds the lock of its folder. Errors:
/// as run_study().
Result<Study> run_study_session(const StudyRequest& request, const Study& study, const Invocation& invocation);

/// A study's rows, held so that nobody else writes into its folder.
struct HeldStudy {
  Study study;
  FolderLock lock;
};

/// The same for a study within a folder that is held already. Nothing where the command line only asks for the list.
Result<std::optional<Study>> run_held_study(StudyRequest& request, std::vector<Variant>& variants,
                                            const Invocation& invocation);

/// The study of `variants` whose failures are results (wry accuracy, wry stress), run as far as it has not been;
/// `frames` are those of its section. Nothing where the command line only asks for the list. Errors: as run_study();
/// locked.
Result<std::optional<HeldStudy>> hold_study(StudyRequest& request, std::vector<Variant>& variants,
                                            const std::optional<std::string>& frames, const Invocation& invocation);

/// Prints the jobs of a study, for people or (--json) for farms that we do not know.
void print_job_graph(const Study& study, const Invocation& invocation);

} // namespace wry::pipeline
