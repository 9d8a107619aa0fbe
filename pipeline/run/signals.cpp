#include "pipeline/run/signals.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <string_view>
#include <system_error>
#include <unistd.h>

namespace wry::pipeline {

namespace {

/// The signal that asked for a stop, or 0. A handler can reach nothing but a static.
std::atomic<int> stop_signal = 0;
static_assert(std::atomic<int>::is_always_lock_free);

void say(std::string_view text) {
  // A handler may call write() only, and nothing can be done if it fails.
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text.data(), text.size());
}

void handle_stop(int signal) {
  const int saved_errno = errno;
  int none = 0;
  if (!stop_signal.compare_exchange_strong(none, signal)) {
    say("\nstopped at once; what was in flight will be made again\n");
    ::_exit(static_cast<int>(ErrorCode::stopped));
  }
  say("\nstopping after this step; once more to stop at once\n");
  errno = saved_errno;
}

} // namespace

Status install_stop_signals() {
  struct sigaction stop {};
  stop.sa_handler = handle_stop;
  stop.sa_flags = SA_RESTART;
  sigemptyset(&stop.sa_mask);
  struct sigaction ignore {};
  ignore.sa_handler = SIG_IGN;
  sigemptyset(&ignore.sa_mask);
  bool installed = true;
  for (const int signal : {SIGTERM, SIGINT})
    installed = installed && ::sigaction(signal, &stop, nullptr) == 0;
  for (const int signal : {SIGPIPE, SIGXFSZ})
    installed = installed && ::sigaction(signal, &ignore, nullptr) == 0;
  if (!installed)
    return make_error(ErrorCode::io, "cannot take over signals: {}", std::generic_category().message(errno));
  return {};
}

bool stop_requested() {
  return stop_signal.load(std::memory_order_relaxed) != 0;
}

Error stopped_by_signal(const std::string& what) {
  const int signal = stop_signal.load();
  const std::string_view name = signal == SIGINT ? "SIGINT" : signal == SIGTERM ? "SIGTERM" : "a signal";
  return make_error(ErrorCode::stopped, "stopped by {}: {}; run the same command again to go on", name, what);
}

void clear_stop_request() {
  stop_signal = 0;
}

} // namespace wry::pipeline
