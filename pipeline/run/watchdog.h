#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace wry::pipeline {

/// Ends a run that makes no progress: a hang must not hold a farm's machine all night.
///
/// A thread looks every tenth of the budget; when progress() was not called for the whole budget it acts once. The
/// action runs on that thread while the hung one may hold any lock, so it may do little: the default prints what was
/// last done and leaves with exit code 70 at once.
class Watchdog {
public:
  struct Settings {
    std::chrono::milliseconds budget = std::chrono::minutes(30);
    std::string name; ///< of the run, for the message
    /// What to do; empty: print `message` to stderr and leave with 70.
    std::function<void(const std::string& message)> action;
  };

  explicit Watchdog(Settings settings);
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// Something was finished; `what` names it, e.g. "step 120, t = 0.41 s".
  void progress(std::string what);

private:
  void watch();
  std::string message() const;

  const Settings m_settings;
  mutable std::mutex m_mutex;
  std::condition_variable m_wake;
  std::string m_last = "the start";
  std::chrono::steady_clock::time_point m_last_time;
  bool m_done = false;
  std::thread m_thread;
};

} // namespace wry::pipeline
