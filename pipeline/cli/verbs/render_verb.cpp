#include <chrono>
#include <thread>

#include <fmt/format.h>

#include "pipeline/cli/shot_run.h"
#include "pipeline/cli/verb.h"
#include "pipeline/run/signals.h"

namespace wry::pipeline {

namespace {

/// Waits until every frame that is asked for is in the cache.
Status wait_for_frames(const ShotSession& session) {
  while (!stop_requested()) {
    const Result<FrameCache> cache = FrameCache::open_to_read(session.out / "frames");
    bool complete = cache.ok();
    for (const int frame : session.frames)
      complete = complete && cache->has_frame(frame);
    if (complete)
      return {};
    if (cache.ok() && !cache->frames().empty())
      return {};
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
  return stopped_by_signal("while waiting for the first frame");
}

} // namespace

Status render_verb(const Invocation& invocation) {
  const Result<ShotSession> session = open_session(invocation);
  if (!session)
    return session.error();
  if (invocation.follow) {
    if (Status status = wait_for_frames(*session); !status)
      return status;
  }
  return draw_session(*session, invocation);
}

} // namespace wry::pipeline
