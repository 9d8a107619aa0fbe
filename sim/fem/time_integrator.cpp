#include "sim/fem/time_integrator.h"

#include <array>
#include <numbers>

namespace wry::fem {

namespace {

constexpr double SDIRK_GAMMA = 1.0 - 1.0 / std::numbers::sqrt2;

/// Makes increments count from where the predictor turns the rotations to.
void centre(Points base_increments, PlannedStage& planned) {
  if (planned.guess_angular.rows() == 0)
    return;
  planned.predictor = base_increments + planned.stage.beta * planned.guess_angular;
  planned.stage.base_increments = base_increments - planned.predictor;
}

NamedArray named(const char* name, const Points& points) {
  return {name, {static_cast<std::size_t>(points.rows()), 3}, {points.data(), points.data() + points.size()}};
}

} // namespace

PlannedStage TimeIntegrator::backward_euler(double dt, double end, const FemState& state) const {
  PlannedStage planned;
  Stage& stage = planned.stage;
  stage.beta = stage.dt = dt;
  stage.time = end;
  stage.start_time = end - dt;
  stage.base_positions = stage.start_positions = state.positions;
  stage.base_velocities = planned.guess_velocities = state.velocities;
  stage.base_angular = planned.guess_angular = state.angular;
  return planned;
}

PlannedStage TimeIntegrator::bdf2(double dt, double end, const FemState& state) const {
  PlannedStage planned = backward_euler(dt, end, state);
  if (m_last_dt == 0.0)
    return planned;
  const double ratio = dt / m_last_dt;
  const double back = ratio * ratio / (1.0 + 2.0 * ratio);
  Stage& stage = planned.stage;
  stage.beta = dt * (1.0 + ratio) / (1.0 + 2.0 * ratio);
  stage.base_positions = state.positions + back * (state.positions - m_last_positions);
  stage.base_velocities = state.velocities + back * (state.velocities - m_last_velocities);
  planned.guess_velocities = state.velocities + ratio * (state.velocities - m_last_velocities);
  if (state.angular.rows() > 0) {
    stage.base_angular = state.angular + back * (state.angular - m_last_angular);
    planned.guess_angular = state.angular + ratio * (state.angular - m_last_angular);
    centre(back * m_last_increments, planned);
  }
  return planned;
}

PlannedStage TimeIntegrator::sdirk2(int index, double dt, double end, const FemState& state,
                                    const Trial& earlier) const {
  PlannedStage planned = backward_euler(dt, end, state);
  Stage& stage = planned.stage;
  stage.beta = SDIRK_GAMMA * dt;
  if (index == 0) {
    stage.time = end - (1.0 - SDIRK_GAMMA) * dt;
    centre(Points::Zero(state.angular.rows(), 3), planned);
    return planned;
  }
  const double rest = 1.0 - SDIRK_GAMMA;
  stage.base_positions = state.positions + rest * dt * earlier.velocities;
  stage.base_velocities = state.velocities + rest / SDIRK_GAMMA * (earlier.velocities - state.velocities);
  planned.guess_velocities = stage.base_velocities;
  if (state.angular.rows() > 0) {
    stage.base_angular = state.angular + rest / SDIRK_GAMMA * (earlier.angular - state.angular);
    planned.guess_angular = stage.base_angular;
    centre(rest * dt * earlier.angular, planned);
  }
  return planned;
}

PlannedStage TimeIntegrator::plan(int index, double dt, double end, const FemState& state, const Trial& earlier) const {
  switch (m_kind) {
  case Integrator::backward_euler:
    break;
  case Integrator::bdf2:
    return bdf2(dt, end, state);
  case Integrator::sdirk2:
    return sdirk2(index, dt, end, state, earlier);
  }
  return backward_euler(dt, end, state);
}

void TimeIntegrator::remember(double dt, const FemState& before, const PlannedStage& last, const Trial& trial) {
  if (m_kind != Integrator::bdf2)
    return;
  m_last_dt = dt;
  m_last_positions = before.positions;
  m_last_velocities = before.velocities;
  m_last_angular = before.angular;
  m_last_increments = trial.increments;
  if (last.predictor.rows() > 0)
    m_last_increments += last.predictor;
}

void TimeIntegrator::save(StateArchive& archive) const {
  if (m_kind != Integrator::bdf2)
    return;
  archive.push_back({"fem/last_dt", {1}, {m_last_dt}});
  if (m_last_dt == 0.0)
    return;
  archive.push_back(named("fem/last_positions", m_last_positions));
  archive.push_back(named("fem/last_velocities", m_last_velocities));
  archive.push_back(named("fem/last_angular", m_last_angular));
  archive.push_back(named("fem/last_increments", m_last_increments));
}

Status TimeIntegrator::restore(const StateArchive& archive, const FemState& state) {
  if (m_kind != Integrator::bdf2)
    return {};
  const NamedArray* dt = find_array(archive, "fem/last_dt", 1);
  if (dt == nullptr)
    return make_error(ErrorCode::io, "checkpoint: fem/last_dt is missing; it was written with another integrator");
  m_last_dt = dt->values[0];
  if (m_last_dt == 0.0)
    return {};
  struct Field {
    const char* name;
    Eigen::Index rows;
    Points* points;
  };
  for (const Field& field : std::array{Field{"fem/last_positions", state.positions.rows(), &m_last_positions},
                                       Field{"fem/last_velocities", state.positions.rows(), &m_last_velocities},
                                       Field{"fem/last_angular", state.angular.rows(), &m_last_angular},
                                       Field{"fem/last_increments", state.angular.rows(), &m_last_increments}}) {
    const NamedArray* array = find_array(archive, field.name, static_cast<std::size_t>(3 * field.rows));
    if (array == nullptr)
      return make_error(ErrorCode::io, "checkpoint: {} with {} entries is missing", field.name, 3 * field.rows);
    *field.points = Eigen::Map<const Points>(array->values.data(), field.rows, 3);
  }
  return {};
}

} // namespace wry::fem
