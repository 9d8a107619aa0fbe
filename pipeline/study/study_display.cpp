#include "pipeline/study/study_display.h"

#include <algorithm>

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "pipeline/report/readable.h"

namespace wry::pipeline {

namespace {

std::size_t terminal_width() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col : 100;
}

std::size_t count(std::span<const JobState> states, JobPhase phase) {
  return static_cast<std::size_t>(
      std::count_if(states.begin(), states.end(), [&](const JobState& state) { return state.phase == phase; }));
}

} // namespace

std::string describe_jobs(std::span<const JobState> states) {
  const std::size_t failed = count(states, JobPhase::failed), skipped = count(states, JobPhase::skipped);
  std::string text = fmt::format("{} of {} jobs", count(states, JobPhase::done) + failed + skipped, states.size());
  if (failed > 0)
    text += fmt::format(", {} failed", failed);
  std::string running;
  for (const JobState& state : states) {
    if (state.phase != JobPhase::running)
      continue;
    running += (running.empty() ? "" : ", ") + state.job->id;
    if (state.percent >= 0)
      running += fmt::format(" {}%", state.percent);
  }
  return running.empty() ? text : text + "; running " + running;
}

double fraction_done(std::span<const JobState> states) {
  double done = 0.0;
  for (const JobState& state : states) {
    if (state.phase == JobPhase::running)
      done += 0.01 * std::max(state.percent, 0);
    else if (state.phase != JobPhase::waiting)
      done += 1.0;
  }
  return states.empty() ? 1.0 : done / static_cast<double>(states.size());
}

StudyDisplay::StudyDisplay(std::string task, Talk talk)
    : m_task(std::move(task))
    , m_quiet(talk == Talk::quiet)
    , m_terminal(isatty(STDERR_FILENO) == 1)
    , m_start(std::chrono::steady_clock::now()) {}

StudyDisplay::~StudyDisplay() {
  if (m_line_open)
    fmt::print(stderr, "\n");
}

void StudyDisplay::show(std::span<const JobState> states) {
  if (m_quiet)
    return;
  const double fraction = fraction_done(states);
  const int percent = static_cast<int>(100.0 * fraction);
  if (!m_terminal) {
    if (percent == m_last_percent)
      return;
    m_last_percent = percent;
    fmt::print(stderr, "{}: progress {}% ({})\n", m_task, percent, describe_jobs(states));
    return;
  }
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - m_start).count();
  std::string line = fmt::format("{} {:3}%  {}", m_task, percent, describe_jobs(states));
  if (fraction > 0.02 && fraction < 1.0)
    line += fmt::format("  {} left", human_duration(elapsed * (1.0 - fraction) / fraction));
  fmt::print(stderr, "\r\033[K{}", line.substr(0, terminal_width() - 1));
  std::fflush(stderr);
  m_line_open = true;
}

} // namespace wry::pipeline
