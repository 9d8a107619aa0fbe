#include "sim/fem/newton.h"

#include <algorithm>
#include <cmath>

#include "sim/base/stopwatch.h"
#include "sim/fem/incremental_potential.h"
#include "sim/fem/rotation_update.h"

namespace wry::fem {

namespace {

/// Relative residual below which a direction that met negative curvature is good enough.
constexpr double TRUNCATED_RESIDUAL = 0.3;
/// Directions along negative curvature in a row before elements are projected.
constexpr int MAX_RIDGES_IN_ROW = 5;
constexpr int MAX_DOUBLINGS = 10;
/// A line is followed further while its slope is steeper than this share of what it was.
constexpr double STILL_STEEP = 0.4;
/// Iterations for which friction is bounded, at most, each time Newton leaps to and fro.
constexpr int MAX_PATIENCE = 3;
/// Held unknowns that go less than this share of what is left of their way are stuck, and given up after so many times.
constexpr double LEAST_SHARE_OF_WAY = 1e-3;
constexpr int MAX_TIMES_STUCK = 5;
constexpr double LINEAR_TOLERANCE_ON_WAY = 1e-2;
constexpr double ARMIJO = 1e-4;
constexpr int MAX_HALVINGS = 50;
/// Relative to the sum of the absolute terms: energy changes below this are round-off and decide nothing.
constexpr double ENERGY_NOISE = 1e-13;
/// The same where the gradient tells of clear progress: it falls to this share.
constexpr double STIFF_ENERGY_NOISE = 1e-9;
constexpr double STIFF_PROGRESS = 0.25;
/// A residual that no longer falls is taken for converged below this multiple of the round-off estimate.
constexpr double FLOOR_MARGIN = 32.0;

class Minimiser {
public:
  Minimiser(const NewtonProblem& problem, const NewtonSettings& settings, const Stage& stage, Trial& trial)
      : m_problem(problem)
      , m_settings(settings)
      , m_stage(stage)
      , m_potential(problem, stage)
      , m_trial(trial)
      , m_next(trial)
      , m_on_way(problem.given != nullptr) {}

  NewtonReport run() {
    evaluate(m_trial, m_now);
    if (!std::isfinite(m_now.energy) || !std::isfinite(m_now.residual))
      return give_up(ENERGY_NOT_FINITE);
    for (;;) {
      const bool arrived = advance_prescribed();
      if (!std::isfinite(m_now.energy) || !std::isfinite(m_now.residual))
        return give_up("the energy is not finite where obstacles went");
      if (arrived && !m_on_way && converged())
        break;
      if (m_report.iterations >= m_settings.max_iterations)
        return give_up(!arrived   ? "obstacles could not reach the end of their way in the Newton iteration limit"
                       : m_on_way ? "drives could not reach the end of their way in the Newton iteration limit"
                                  : "the Newton iteration limit was reached");
      if (m_on_way) {
        ++m_report.iterations;
        if (!take_held_along())
          return give_up("a drive leads through an obstacle, or turns matter inside out");
        continue;
      }
      if (!find_direction())
        return give_up("no descent direction was found");
      ++m_report.iterations;
      if (!search_line())
        return at_floor() ? finish() : give_up("the line search found no decrease");
    }
    return finish();
  }

private:
  NewtonReport finish() {
    m_report.converged = true;
    m_report.residual = m_now.residual;
    return m_report;
  }

  NewtonReport give_up(const char* trouble) {
    m_report.trouble = trouble;
    m_report.residual = m_now.residual;
    return m_report;
  }

  /// True when everything prescribed is where it has to be at the end of the step.
  bool advance_prescribed() {
    if (m_left == 0.0)
      return true;
    double left = 0.0;
    for (EnergyTerm* term : m_problem.terms)
      left = std::max(left, term->advance_prescribed(m_trial));
    if (left != m_left)
      evaluate(m_trial, m_now);
    m_left = left;
    return left == 0.0;
  }

  bool at_floor() const { return m_now.residual <= FLOOR_MARGIN * m_report.round_off_floor; }

  bool converged() {
    if (m_now.residual <= std::max(m_settings.tolerance, m_settings.relative_tolerance * m_first_residual))
      return true;
    const bool stagnates = m_report.iterations > 0 && m_now.residual > 0.5 * m_previous_residual;
    return stagnates && at_floor();
  }

  void evaluate(const Trial& trial, Evaluation& out) {
    const Stopwatch watch(m_report.evaluate_ms);
    m_potential.evaluate(trial, out);
  }

  void assemble(Projection projection) {
    const Stopwatch watch(m_report.assemble_ms);
    sum_matrix(projection);
    hold_matrix();
  }

  void sum_matrix(Projection projection) {
    m_report.projected_elements += m_potential.sum_matrix(m_trial, m_now, projection);
  }

  void hold_matrix() { m_report.round_off_floor = m_potential.hold_matrix(m_trial); }

  double linear_tolerance() const {
    if (m_settings.linear_tolerance > 0.0)
      return m_settings.linear_tolerance;
    const double progress = m_now.residual / m_first_residual;
    const double wanted = std::min(1e-2, 0.1 * std::sqrt(progress));
    const double enough = 0.3 * m_settings.tolerance / m_now.residual;
    return std::clamp(wanted, std::min(enough, 1e-2), 1e-2);
  }

  SolveReport solve_linear(double tolerance) {
    const Stopwatch watch(m_report.solve_ms);
    const std::function<const std::vector<Mat3>&()> rotations = [&]() -> const std::vector<Mat3>& {
      return m_problem.node_rotations(m_trial);
    };
    const LinearProblem linear{m_problem.matrix, m_right_side, tolerance, rotations};
    const SolveReport report = m_problem.linear.solve(linear, m_direction);
    m_report.linear_iterations += report.iterations;
    return report;
  }

  /// Puts what is left of the way of the held unknowns into m_way, packed; zero for the others.
  void find_way() {
    const DofLayout& layout = m_problem.model.layout;
    m_way.assign(layout.dof_count(), 0.0);
    for (int node = 0; node < layout.node_count(); ++node) {
      for (int i = 0; i < layout.dofs(node); ++i) {
        const std::size_t dof = layout.dof(node) + static_cast<std::size_t>(i);
        if (m_problem.held[dof])
          m_way[dof] = i < 3 ? m_problem.given->velocities(node, i) - m_trial.velocities(node, i)
                             : m_problem.given->angular(node, i - 3) - m_trial.angular(node, i - 3);
      }
    }
  }

  /// A step of Newton's that has the held unknowns go on along their way, and the free ones follow them: K (d_free +
  /// d_held) = -g. It goes as far as nothing collides and the energy stays finite. False when that is next to nothing.
  bool take_held_along() {
    find_way();
    bool solved = false;
    for (const Projection projection : {Projection::elements_with_inertia, Projection::elements}) {
      {
        const Stopwatch watch(m_report.assemble_ms);
        sum_matrix(projection);
        pad(m_problem.model.layout, m_way, m_padded_way);
        m_padded_force.assign(m_padded_way.size(), 0.0);
        m_problem.matrix.multiply(m_padded_way, m_padded_force, m_problem.threads);
        unpad(m_problem.model.layout, m_padded_force, m_right_side);
        for (std::size_t i = 0; i < m_right_side.size(); ++i)
          m_right_side[i] = m_problem.held[i] ? 0.0 : -m_now.gradient[i] - m_right_side[i];
        hold_matrix();
      }
      const SolveReport report = solve_linear(LINEAR_TOLERANCE_ON_WAY);
      solved = report.end != SolveEnd::indefinite;
      if (solved)
        break;
    }
    if (!solved)
      return false;
    for (std::size_t i = 0; i < m_way.size(); ++i) {
      if (m_problem.held[i])
        m_direction[i] = m_way[i];
    }
    double fraction = step_limit();
    for (int halvings = 0; halvings <= MAX_HALVINGS; ++halvings, fraction *= 0.5) {
      move(fraction);
      evaluate(m_next, m_tried);
      if (std::isfinite(m_tried.energy) && std::isfinite(m_tried.residual)) {
        std::swap(m_trial, m_next);
        std::swap(m_now, m_tried);
        m_previous_residual = m_tried.residual;
        m_on_way = fraction < 1.0;
        m_times_stuck = fraction < LEAST_SHARE_OF_WAY ? m_times_stuck + 1 : 0;
        return m_times_stuck < MAX_TIMES_STUCK;
      }
      ++m_report.halvings;
    }
    return false;
  }

  /// True if m_direction is a descent direction.
  bool solve() {
    for (std::size_t i = 0; i < m_right_side.size(); ++i)
      m_right_side[i] = -m_now.gradient[i];
    const SolveReport report = solve_linear(linear_tolerance());
    // A direction that goes on along negative curvature spares the projection (Steihaug 1983). Far from a minimum,
    // where it is met at once, projected elements lead further; once they have led to a ridge, they only creep along
    // it.
    m_over_ridge = report.end == SolveEnd::indefinite;
    if (m_over_ridge && (m_direction.empty() || m_ridges_in_row >= MAX_RIDGES_IN_ROW ||
                         (report.relative_residual > TRUNCATED_RESIDUAL && !m_projected_before)))
      return false;
    m_slope = 0.0;
    for (std::size_t i = 0; i < m_direction.size(); ++i)
      m_slope += m_direction[i] * m_now.gradient[i];
    return m_slope < 0.0;
  }

  bool find_direction() {
    if (m_first_residual == 0.0)
      m_first_residual = m_now.residual;
    m_right_side.resize(m_now.gradient.size());
    m_projected_before = m_projected;
    for (EnergyTerm* term : m_problem.terms)
      term->bound_friction(m_bound_friction_for > 0);
    for (const Projection projection :
         {Projection::contacts, Projection::elements_with_inertia, Projection::elements}) {
      if (projection == Projection::contacts && m_keep_projecting)
        continue;
      m_projected = projection != Projection::contacts;
      assemble(projection);
      if (solve())
        return true;
    }
    for (double shift = 1e-6; shift < 1.0; shift *= 100.0) {
      assemble(Projection::elements);
      m_potential.add_shift(shift);
      if (solve())
        return true;
    }
    return false;
  }

  void move(double fraction) {
    const DofLayout& layout = m_problem.model.layout;
    for (int node = 0; node < layout.node_count(); ++node) {
      const double* change = m_direction.data() + layout.dof(node);
      for (int i = 0; i < 3; ++i)
        m_next.velocities(node, i) = m_trial.velocities(node, i) + fraction * change[i];
      if (layout.dofs(node) == 6) {
        for (int i = 0; i < 3; ++i)
          m_next.angular(node, i) = m_trial.angular(node, i) + fraction * change[3 + i];
      }
    }
    update_trial(m_stage, m_next);
  }

  double step_limit() {
    const DofLayout& layout = m_problem.model.layout;
    m_position_change.resize(layout.node_count(), 3);
    for (int node = 0; node < layout.node_count(); ++node)
      m_position_change.row(node) =
          m_stage.beta * Eigen::Map<const Vec3>(m_direction.data() + layout.dof(node)).transpose();
    double limit = 1.0;
    for (const EnergyTerm* term : m_problem.terms)
      limit = std::min(limit, term->step_limit(m_trial, m_position_change));
    return limit;
  }

  bool acceptable(double fraction) const {
    if (!std::isfinite(m_tried.energy) || !std::isfinite(m_tried.residual))
      return false;
    const double change = m_tried.energy - m_now.energy;
    if (change <= ARMIJO * fraction * m_slope)
      return true;
    // Round-off hides the decrease: let the gradient decide.
    const double magnitude = std::max(m_now.magnitude, m_tried.magnitude);
    if (std::abs(change) <= ENERGY_NOISE * magnitude && m_tried.residual <= m_now.residual)
      return true;
    // Energies of stiff matter cancel to far less than what they are made of, and are noisier than their size tells.
    return std::abs(change) <= STIFF_ENERGY_NOISE * magnitude && m_tried.residual <= STIFF_PROGRESS * m_now.residual;
  }

  /// Bounds friction when Newton leaps to and fro between sticking and sliding, longer each time it happens.
  void watch_friction(int halvings) {
    if (m_bound_friction_for > 0) {
      --m_bound_friction_for;
    } else if (halvings > 0 || m_tried.residual > m_now.residual) {
      m_bound_friction_for = m_patience;
      m_patience = std::min(2 * m_patience, MAX_PATIENCE);
    }
  }

  /// Goes on as long as it goes down: where the energy is not convex, the length of a direction means little.
  void lengthen() {
    double fraction = 1.0;
    for (int doublings = 0; doublings < MAX_DOUBLINGS; ++doublings) {
      double slope = 0.0;
      for (std::size_t i = 0; i < m_direction.size(); ++i)
        slope += m_direction[i] * m_tried.gradient[i];
      if (!(slope < STILL_STEEP * m_slope))
        return;
      fraction *= 2.0;
      m_position_change *= 2.0;
      for (const EnergyTerm* term : m_problem.terms) {
        if (term->step_limit(m_trial, m_position_change) < 1.0)
          return;
      }
      std::swap(m_next, m_shorter);
      std::swap(m_tried, m_tried_shorter);
      m_next = m_shorter;
      move(fraction);
      evaluate(m_next, m_tried);
      if (!std::isfinite(m_tried.residual) || !(m_tried.energy < m_tried_shorter.energy)) {
        std::swap(m_next, m_shorter);
        std::swap(m_tried, m_tried_shorter);
        return;
      }
    }
  }

  bool search_line() {
    const double limit = step_limit();
    double fraction = limit;
    for (int halvings = 0; halvings <= MAX_HALVINGS; ++halvings, fraction *= 0.5) {
      move(fraction);
      evaluate(m_next, m_tried);
      if (acceptable(fraction)) {
        const bool shapeless = m_over_ridge || m_projected;
        if (shapeless && halvings == 0 && limit >= 1.0)
          lengthen();
        m_keep_projecting = m_projected && halvings > 0;
        m_ridges_in_row = m_over_ridge ? m_ridges_in_row + 1 : 0;
        watch_friction(halvings);
        std::swap(m_trial, m_next);
        std::swap(m_now, m_tried);
        m_previous_residual = m_tried.residual;
        return true;
      }
      ++m_report.halvings;
      if (at_floor() && halvings > 8)
        return false;
    }
    return false;
  }

  const NewtonProblem& m_problem;
  const NewtonSettings& m_settings;
  const Stage& m_stage;
  IncrementalPotential m_potential;
  Trial& m_trial;
  Trial m_next;
  Trial m_shorter;
  Evaluation m_now, m_tried, m_tried_shorter;
  std::vector<double> m_right_side, m_direction;
  std::vector<double> m_way; ///< of the held unknowns
  AlignedVector<double> m_padded_way, m_padded_force;
  Points m_position_change;
  double m_slope = 0.0;
  double m_first_residual = 0.0;
  double m_previous_residual = 0.0;
  bool m_projected = false; ///< the last direction came from projected elements
  bool m_keep_projecting = false;
  bool m_projected_before = false; ///< so did the one before
  bool m_over_ridge = false;       ///< the direction follows negative curvature
  int m_ridges_in_row = 0;
  int m_bound_friction_for = 0; ///< iterations
  int m_patience = 1;           ///< iterations for which friction will be bounded the next time
  double m_left = 1.0;          ///< of the way of what is prescribed
  bool m_on_way;                ///< held unknowns are not where they have to be at the end
  int m_times_stuck = 0;
  NewtonReport m_report;
};

} // namespace

NewtonReport sum_of(const NewtonReport& earlier, const NewtonReport& later) {
  NewtonReport sum = later;
  sum.iterations += earlier.iterations;
  sum.linear_iterations += earlier.linear_iterations;
  sum.halvings += earlier.halvings;
  sum.projected_elements += earlier.projected_elements;
  sum.evaluate_ms += earlier.evaluate_ms;
  sum.assemble_ms += earlier.assemble_ms;
  sum.solve_ms += earlier.solve_ms;
  return sum;
}

void update_trial(const Stage& stage, Trial& trial) {
  trial.positions = stage.base_positions + stage.beta * trial.velocities;
  if (trial.angular.rows() == 0)
    return;
  trial.increments = stage.beta * trial.angular;
  if (stage.exponential) {
    for (Eigen::Index node = 0; node < trial.increments.rows(); ++node)
      trial.increments.row(node) = cayley_of_rotation_vector(trial.increments.row(node)).transpose();
    return;
  }
  if (stage.base_increments.rows() > 0)
    trial.increments += stage.base_increments;
}

NewtonReport minimise(const NewtonProblem& problem, const NewtonSettings& settings, const Stage& stage, Trial& trial) {
  return Minimiser(problem, settings, stage, trial).run();
}

} // namespace wry::fem
