#pragma once

#include <chrono>
#include <span>
#include <string>

#include "pipeline/run/engines/engine.h"

namespace wry::pipeline {

/// Shows how far a study is: a live line on a terminal, plain lines `progress 42%` on a pipe.
class StudyDisplay {
public:
  enum class Talk { normal, quiet };
  StudyDisplay(std::string task, Talk talk);
  ~StudyDisplay();
  StudyDisplay(const StudyDisplay&) = delete;
  StudyDisplay& operator=(const StudyDisplay&) = delete;

  void show(std::span<const JobState> states);

private:
  std::string m_task;
  bool m_quiet;
  bool m_terminal;
  bool m_line_open = false;
  int m_last_percent = -1;
  std::chrono::steady_clock::time_point m_start;
};

/// "7 of 24 jobs, 1 failed; running 003-1f0c9a2b.simulate 42%, 004-...": what the line says.
std::string describe_jobs(std::span<const JobState> states);
/// Part of the work that is over, 0 to 1; running jobs count by their percentage.
double fraction_done(std::span<const JobState> states);

} // namespace wry::pipeline
