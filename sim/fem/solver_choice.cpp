#include "sim/fem/solver_choice.h"

#include <algorithm>
#include <cmath>

#include "sim/fem/linear/solver_cost.h"
#include "sim/fem/linear/sparse_factor.h"

namespace wry::fem {

namespace {

/// Beyond this a factor is not worth analysing.
constexpr int MOST_NODES_TO_FACTOR = 300000;

/// Sound speed x step / edge of the stiffest body: how many elements feel each other within a step.
double wave_crossing(const FemPlan& plan, const FemScene& scene) {
  double crossing = 0.0;
  for (std::size_t i = 0; i < plan.bodies.size(); ++i) {
    const FemMaterial& m = plan.bodies[i].material;
    const double mu = m.youngs_modulus / (2.0 * (1.0 + m.poisson_ratio));
    const double lambda = 2.0 * mu * m.poisson_ratio / (1.0 - 2.0 * m.poisson_ratio);
    const double speed = std::sqrt((lambda + 2.0 * mu) / m.density);
    crossing = std::max(crossing, speed * plan.settings.max_time_step / scene.edges[i]);
  }
  return crossing;
}

/// sqrt(mu L_c^2 C / (4 mu_c)) / edge: curvature energy against the coupling of microrotations to the matter.
double rotation_reach(const FemPlan& plan, const FemScene& scene) {
  double reach = 0.0;
  for (std::size_t i = 0; i < plan.bodies.size(); ++i) {
    const FemMaterial& m = plan.bodies[i].material;
    if (m.curvature == CurvatureModel::none || !(m.couple_modulus_ratio > 0.0))
      continue;
    const double largest = m.curvature == CurvatureModel::orthotropic ? m.curvature_stiffness.maxCoeff()
                                                                      : std::max({m.alpha, m.beta, m.gamma});
    reach = std::max(reach, m.length_scale * std::sqrt(largest / (4.0 * m.couple_modulus_ratio)) / scene.edges[i]);
  }
  return reach;
}

double longest_path(const FemPlan& plan, const FemScene& scene) {
  double longest = 0.0;
  for (std::size_t i = 0; i < plan.bodies.size(); ++i) {
    const Points& vertices = plan.bodies[i].mesh->vertices;
    const Vec3 extent = vertices.colwise().maxCoeff() - vertices.colwise().minCoeff();
    longest = std::max(longest, extent.norm() / scene.edges[i]);
  }
  return longest;
}

Result<ChosenMethod> make(LinearSolver solver, std::string reason, const BlockMatrix& matrix, const Threads& threads) {
  ChosenMethod chosen;
  chosen.choice = {solver, std::move(reason)};
  if (solver == LinearSolver::pcg) {
    chosen.method = make_block_jacobi_pcg(matrix, threads);
    return chosen;
  }
  Result<std::unique_ptr<LinearMethod>> method =
      solver == LinearSolver::cholesky ? make_cholesky(matrix) : make_stale_cholesky(matrix, threads);
  if (!method)
    return std::move(method).error();
  chosen.method = std::move(method).value();
  return chosen;
}

enum class LookAtFactor { no, yes };

SolverDemand demand_of(const FemPlan& plan, const FemScene& scene, const BlockMatrix& matrix, LookAtFactor look) {
  SolverDemand demand;
  demand.matrix_entries = matrix.entry_count();
  demand.unknowns = static_cast<double>(scene.model.layout.dof_count());
  demand.wave_crossing = wave_crossing(plan, scene);
  demand.rotation_reach = rotation_reach(plan, scene);
  demand.longest_path = longest_path(plan, scene);
  demand.contacts = plan.contact.has_value();
  demand.factor_available = false;
  if (look == LookAtFactor::yes && scene.model.layout.node_count() <= MOST_NODES_TO_FACTOR) {
    const Result<std::unique_ptr<SparseFactor>> factor = SparseFactor::create(matrix);
    demand.factor_available = factor.ok();
    if (factor)
      demand.cost = factor.value()->cost();
  }
  return demand;
}

} // namespace

Result<ChosenMethod> choose_linear_method(const FemPlan& plan, const FemScene& scene, const BlockMatrix& matrix,
                                          const Threads& threads) {
  const LinearSolver asked = plan.settings.linear_solver;
  const SolverDemand demand =
      demand_of(plan, scene, matrix, asked == LinearSolver::pcg ? LookAtFactor::no : LookAtFactor::yes);
  if (asked != LinearSolver::automatic) {
    Result<ChosenMethod> chosen = make(asked, "asked for", matrix, threads);
    if (chosen)
      chosen->choice.seconds_per_direction = seconds_per_direction(asked, demand);
    return chosen;
  }
  SolverDecision decision = choose_solver(demand);
  Result<ChosenMethod> chosen = make(decision.solver, std::move(decision.reason), matrix, threads);
  if (!chosen)
    return chosen;
  chosen->choice.seconds_per_direction = decision.seconds_per_direction;
  if (decision.iterations_worth_a_factor > 0)
    chosen->method = make_pcg_or_factor(matrix, threads, decision.iterations_worth_a_factor);
  return chosen;
}

} // namespace wry::fem
