#include "pipeline/run/watchdog.h"

#include <cstdio>
#include <unistd.h>
#include <utility>

#include "sim/base/result.h"

namespace wry::pipeline {

namespace {

void leave(const std::string& message) {
  const std::string line = message + "\n";
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, line.data(), line.size());
  ::_exit(static_cast<int>(ErrorCode::solver));
}

} // namespace

Watchdog::Watchdog(Settings settings)
    : m_settings(std::move(settings))
    , m_last_time(std::chrono::steady_clock::now())
    , m_thread([this] { watch(); }) {}

Watchdog::~Watchdog() {
  {
    const std::lock_guard lock(m_mutex);
    m_done = true;
  }
  m_wake.notify_all();
  m_thread.join();
}

void Watchdog::progress(std::string what) {
  const std::lock_guard lock(m_mutex);
  m_last = std::move(what);
  m_last_time = std::chrono::steady_clock::now();
}

std::string Watchdog::message() const {
  const double seconds = std::chrono::duration<double>(m_settings.budget).count();
  return fmt::format(
      "{}: no progress for {:.3g} s after {}; giving up. What was finished is kept: run the same command "
      "again to go on, or allow more time per step",
      m_settings.name.empty() ? "the run" : m_settings.name, seconds, m_last);
}

void Watchdog::watch() {
  std::unique_lock lock(m_mutex);
  while (!m_done) {
    m_wake.wait_for(lock, m_settings.budget / 10);
    if (m_done || std::chrono::steady_clock::now() - m_last_time < m_settings.budget)
      continue;
    const std::string text = message();
    lock.unlock();
    m_settings.action ? m_settings.action(text) : leave(text);
    return;
  }
}

} // namespace wry::pipeline
