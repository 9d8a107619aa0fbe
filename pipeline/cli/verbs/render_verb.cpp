#include "pipeline/cli/shot_run.h"
#include "pipeline/cli/verb.h"
#include "pipeline/run/signals.h"

#include <chrono>
#include <thread>

namespace wry::pipeline {

namespace {

/// Waits until there is a cache to look at, as long as somebody may be about to make one.
Status wait_for_cache(const ShotSession& session) {
  constexpr int LOOKS = 120; // half a second apart
  for (int look = 0; look < LOOKS && !stop_requested();) {
    if (const Result<FrameCache> cache = FrameCache::open_to_read(session.out / "frames"); cache && cache->has_static())
      return {};
    look = is_being_simulated(session.out) ? 0 : look + 1;
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
  if (stop_requested())
    return stopped_by_signal("while waiting for the first frame");
  return make_error(ErrorCode::missing_input, "{} has no frames, and nothing simulates them; run `wry simulate`",
                    session.out.string());
}

} // namespace

Status render_verb(const Invocation& invocation) {
  const Result<ShotSession> session = open_session(invocation);
  if (!session)
    return session.error();
  if (invocation.follow) {
    if (Status status = wait_for_cache(*session); !status)
      return status;
  }
  if (Status status = draw_session(*session, invocation); !status)
    return status;
  return invocation.part.empty() ? encode_session(*session) : Status();
}

} // namespace wry::pipeline
