#pragma once

#include <chrono>

namespace wry {

/// Adds the time of a scope to a number [ms].
class Stopwatch {
public:
  explicit Stopwatch(double& milliseconds)
      : m_milliseconds(milliseconds)
      , m_start(std::chrono::steady_clock::now()) {}
  ~Stopwatch() {
    m_milliseconds += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - m_start).count();
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

private:
  double& m_milliseconds;
  std::chrono::steady_clock::time_point m_start;
};

} // namespace wry
