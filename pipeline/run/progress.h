#pragma once

#include <chrono>
#include <cstdio>
#include <string>

namespace wry::pipeline {

/// Shows how far a long task is: a bar with the time left on a terminal, lines `progress 42%` on a pipe.
class Progress {
public:
  enum class Mode { automatic, quiet };

  /// `total` units of work, of which `already` were done before this run.
  Progress(std::string task, double total, double already, Mode mode);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `done` units in all are finished; `note` is shown behind, e.g. "frame 12, 3 iterations".
  void update(double done, const std::string& note);
  /// Ends the line of the bar.
  void finish();

private:
  void draw_bar(double fraction, const std::string& note, double seconds_left) const;

  std::string m_task;
  double m_total;
  double m_already;
  bool m_quiet;
  bool m_terminal;
  bool m_line_open = false;
  int m_last_percent = -1;
  std::chrono::steady_clock::time_point m_start;
  std::chrono::steady_clock::time_point m_last_line;
};

} // namespace wry::pipeline
