#include "pipeline/run/progress.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <unistd.h>

#include "pipeline/report/readable.h"

namespace wry::pipeline {

namespace {

constexpr int BAR_WIDTH = 28;
constexpr double SECONDS_BETWEEN_LINES = 10.0;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

} // namespace

Progress::Progress(std::string task, double total, double already, Mode mode)
    : m_task(std::move(task))
    , m_total(std::max(total, 1e-12))
    , m_already(already)
    , m_quiet(mode == Mode::quiet)
    , m_terminal(isatty(STDERR_FILENO) == 1)
    , m_start(std::chrono::steady_clock::now())
    , m_last_line(m_start) {}

Progress::~Progress() {
  finish();
}

void Progress::update(double done, const std::string& note) {
  if (m_quiet)
    return;
  const double fraction = std::clamp(done / m_total, 0.0, 1.0);
  const double elapsed = seconds_since(m_start);
  const double here = done - m_already;
  const double seconds_left = here > 0.0 ? elapsed * (m_total - done) / here : -1.0;
  if (m_terminal) {
    draw_bar(fraction, note, seconds_left);
    m_line_open = true;
    return;
  }
  const int percent = static_cast<int>(std::floor(fraction * 100.0));
  const bool due = seconds_since(m_last_line) >= SECONDS_BETWEEN_LINES || percent == 100 || m_last_percent < 0;
  if (percent == m_last_percent || !due)
    return;
  m_last_percent = percent;
  m_last_line = std::chrono::steady_clock::now();
  const std::string left = seconds_left >= 0.0 ? ", " + human_duration(seconds_left) + " left" : "";
  fmt::print(stderr, "{}: progress {}% ({}{})\n", m_task, percent, note, left);
  std::fflush(stderr);
}

void Progress::finish() {
  if (m_line_open)
    fmt::print(stderr, "\n");
  m_line_open = false;
}

void Progress::draw_bar(double fraction, const std::string& note, double seconds_left) const {
  const int filled = static_cast<int>(fraction * BAR_WIDTH);
  const std::string bar = std::string(filled, '#') + std::string(BAR_WIDTH - filled, '.');
  const std::string left = seconds_left >= 0.0 ? human_duration(seconds_left) + " left" : "";
  fmt::print(stderr, "\r\033[K{} [{}] {:3.0f}%  {}  {}", m_task, bar, fraction * 100.0, note, left);
  std::fflush(stderr);
}

} // namespace wry::pipeline
