#pragma once

#include "sim/base/result.h"
#include "sim/fem/fem_model.h"
#include "sim/fem/fem_plan.h"
#include "sim/fem/fem_state.h"

namespace wry::fem {

/// One solve of a step, and where it is expected to end.
struct PlannedStage {
  Stage stage;
  /// a*: the increments by which the stored rotations are turned before the solve, so that what is solved for stays
  /// small: with rotary inertia a method of second order loses an order without (spec §8). Empty: none.
  Points predictor;
  Points guess_velocities, guess_angular;
};

/// Turns a step of the system into solves of the incremental potential (spec §8): backward Euler, BDF2 with steps of
/// any length, and SDIRK2 with gamma = 1 - 1/sqrt(2).
class TimeIntegrator {
public:
  explicit TimeIntegrator(Integrator kind)
      : m_kind(kind) {}

  int stage_count() const { return m_kind == Integrator::sdirk2 ? 2 : 1; }
  /// Whether solves turn the stored rotations ahead.
  bool predicts() const { return m_kind != Integrator::backward_euler; }

  /// Stage `index` of a step of `dt` that ends at `end`; `earlier` is the result of the stage before it.
  PlannedStage plan(int index, double dt, double end, const FemState& state, const Trial& earlier) const;

  /// Remembers what the next step needs of this one. `before`: the state at its start.
  void remember(double dt, const FemState& before, const PlannedStage& last, const Trial& trial);

  void save(StateArchive& archive) const;
  /// Errors: io when the arrays do not fit.
  Status restore(const StateArchive& archive, const FemState& state);

private:
  PlannedStage backward_euler(double dt, double end, const FemState& state) const;
  PlannedStage bdf2(double dt, double end, const FemState& state) const;
  PlannedStage sdirk2(int index, double dt, double end, const FemState& state, const Trial& earlier) const;

  Integrator m_kind;
  double m_last_dt = 0.0;   ///< of the step before [s]; 0: there was none
  Points m_last_positions;  ///< at its start
  Points m_last_velocities; ///< at its start
  Points m_last_angular;    ///< at its start
  Points m_last_increments; ///< of the whole step
};

} // namespace wry::fem
