#include "sim/fem/step_control.h"

#include <algorithm>
#include <cmath>

namespace wry::fem {

namespace {

constexpr int SUCCESSES_TO_GROW = 4;

} // namespace

StepControl::Step StepControl::next(double time, double end, double longest) const {
  const double remaining = end - time;
  const double count = std::max(1.0, std::ceil(remaining / std::min(m_current, longest) - 1e-6));
  return {remaining / count, count == 1.0};
}

void StepControl::succeeded() {
  if (m_current >= m_longest || ++m_successes < SUCCESSES_TO_GROW)
    return;
  m_current = std::min(m_longest, 2.0 * m_current);
  m_successes = 0;
}

bool StepControl::failed(double dt) {
  m_successes = 0;
  if (0.5 * dt < m_shortest)
    return false;
  m_current = 0.5 * dt;
  return true;
}

} // namespace wry::fem
