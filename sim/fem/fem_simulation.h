#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sim/base/isa.h"
#include "sim/base/parallel.h"
#include "sim/base/result.h"
#include "sim/fem/fem_plan.h"
#include "sim/state/frame.h"
#include "sim/state/state_archive.h"

namespace wry::fem {

/// What one accepted step did; a row of stats.csv.
struct StepStats {
  double time = 0.0; ///< at the end of the step [s]
  double dt = 0.0;   ///< [s]
  int newton_iterations = 0;
  int linear_iterations = 0;
  int line_search_halvings = 0;
  int projected_elements = 0;  ///< element Hessians clamped to positive, summed over iterations
  int cuts = 0;                ///< attempts with a larger dt that failed before
  int contacts = 0;            ///< active contacts at the end
  double least_distance = 0.0; ///< smallest gap to an obstacle [m]; infinity without contact
  double residual = 0.0;       ///< final gradient norm [N s]
  double kinetic_energy = 0.0, elastic_energy = 0.0, curvature_energy = 0.0, gravity_energy = 0.0; ///< [J]
  double evaluate_ms = 0.0, assemble_ms = 0.0, solve_ms = 0.0, total_ms = 0.0;                     ///< wall time
  double contact_search_ms = 0.0; ///< of evaluate_ms and the line search: who is near whom
  double safe_step_ms = 0.0;      ///< continuous collision detection
};

/// The linear solver that will run and why, for `wry plan`.
struct SolverChoice {
  LinearSolver solver = LinearSolver::pcg;
  std::string reason;
  double seconds_per_direction = 0.0; ///< predicted
};

/// Solids in time: minimises the incremental potential (spec §5) step by step.
class FemSimulation {
public:
  /// Errors: bad_input for degenerate elements, singular settings (mu_c = 0 with L_c = 0 and j0 = 0) or bodies that
  /// start below a plane; unavailable when a solver is not in this build.
  static Result<std::unique_ptr<FemSimulation>> create(FemPlan plan, int threads, Isa isa);
  virtual ~FemSimulation() = default;

  /// One step of at most the plan's max_time_step that does not pass `end`; landing on `end` exactly when near. The
  /// step is cut when Newton fails and grows again. Errors: solver, with the numbers, when the floor is reached; the
  /// state is then that of the last accepted step.
  virtual Result<StepStats> step(double end) = 0;

  virtual double time() const = 0;

  /// What does not change, for the frame cache.
  virtual SceneStatic scene_static() const = 0;
  /// The bodies as they are now: position, velocity, and for micropolar bodies microrotation (vertices x 4),
  /// angular_velocity; per tet: strain energy density [J/m^3]. `number` is the frame's.
  virtual Frame snapshot(int number) const = 0;

  /// All mutable state, float64; restore() continues bit for bit. Errors: io when the arrays do not fit the plan.
  virtual StateArchive archive() const = 0;
  virtual Status restore(const StateArchive& archive) = 0;

  virtual SolverChoice solver_choice() const = 0;
  /// The residual to which steps of `dt` are solved [N s]: the plan's tolerance, unless that is more than a thousandth
  /// of what gravity gives the bodies in a step (and more than moves them by a hundred-thousandth of their size): tiny
  /// bodies would not move at all.
  virtual double newton_tolerance(double dt) const = 0;
  virtual std::size_t dof_count() const = 0;
  virtual std::size_t memory_bytes() const = 0; ///< estimate of what the arrays and factors need [B]
  /// What the linear solver adds to a checkpoint, where it goes on with an earlier factor [B].
  virtual std::size_t solver_bytes_in_checkpoint() const = 0;
};

} // namespace wry::fem
