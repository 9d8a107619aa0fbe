#pragma once

#include <vector>

#include "pipeline/cli/shot_session.h"
#include "pipeline/run/measure_frames.h"
#include "pipeline/run/render_frames.h"
#include "pipeline/run/simulate.h"

namespace wry::pipeline {

/// Simulates a session's shot into its folder, whose lock the caller holds, and measures its frames.
Result<MeasureTable> simulate_session(const ShotSession& session, const ScenePlan& plan, const Invocation& invocation);

/// Draws a session's pictures in one process per core. Errors: the first of those of the processes.
Status draw_session(const ShotSession& session, const Invocation& invocation);

/// Encodes each view's pictures as a film; only a note where ffmpeg is missing.
Status encode_session(const ShotSession& session);

} // namespace wry::pipeline
