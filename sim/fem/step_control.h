#pragma once

namespace wry::fem {

/// How long the next step is: halved on failure, doubled after a few successes, and cut evenly so that steps land on
/// the end of each frame.
class StepControl {
public:
  StepControl(double longest, double shortest)
      : m_longest(longest)
      , m_shortest(shortest)
      , m_current(longest) {}

  struct Step {
    double dt = 0.0;
    bool lands = false; ///< the step ends at `end`: set the time to it exactly
  };
  /// The next step from `time` towards `end`, at most `longest`.
  Step next(double time, double end, double longest) const;

  void succeeded();
  /// False when the floor is reached: nothing shorter may be tried. `dt` is the step that failed.
  bool failed(double dt);

  double current() const { return m_current; }
  int successes() const { return m_successes; }
  void restore(double current, int successes) {
    m_current = current;
    m_successes = successes;
  }

private:
  double m_longest;
  double m_shortest;
  double m_current;
  int m_successes = 0;
};

} // namespace wry::fem
