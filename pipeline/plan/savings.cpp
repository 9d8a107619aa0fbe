#include "pipeline/plan/savings.h"

#include "pipeline/plan/cost.h"

namespace wry::pipeline {

namespace {

/// Whether two plans have linear systems of the same entries.
bool same_systems(const fem::FemPlan& a, const fem::FemPlan& b) {
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    const fem::FemMaterial &first = a.bodies[i].material, &second = b.bodies[i].material;
    if (first.model != second.model || first.curvature != second.curvature)
      return false;
  }
  return true;
}

/// The estimate of a plan that is a variant of `own`.
CostEstimate cost_of_variant(const shots::Shot& shot, ScenePlan& variant, const ScenePlan& own, Isa isa, int threads) {
  variant.cost = estimate_cost(shot, variant);
  if (variant.cost.newton_directions == 0.0)
    return variant.cost;
  if (same_systems(own.sim.fem, variant.sim.fem)) {
    variant.cost.seconds_of_directions =
        own.cost.seconds_of_directions * variant.cost.newton_directions / own.cost.newton_directions;
    const CostEstimate without_solver = estimate_cost(shot, own);
    variant.cost.memory_bytes += own.cost.memory_bytes - without_solver.memory_bytes;
    variant.cost.bytes_per_checkpoint += own.cost.bytes_per_checkpoint - without_solver.bytes_per_checkpoint;
  } else if (Status status = describe_solver(variant, isa, threads); !status)
    variant.cost.seconds_of_directions = own.cost.seconds_of_directions; // what it says is not of this scene
  return variant.cost;
}

} // namespace

void describe_savings(const shots::Shot& shot, ScenePlan& plan, Isa isa, int threads) {
  const double frames = plan.sim.last_frame - plan.sim.first_frame + 1;
  for (PlanLine& line : plan.left_out) {
    if (!line.with)
      continue;
    ScenePlan variant = plan;
    line.with(variant);
    const CostEstimate cost = cost_of_variant(shot, variant, plan, isa, threads);
    const auto more = [](std::uint64_t with, std::uint64_t without) {
      return static_cast<double>(with) - static_cast<double>(without);
    };
    line.saving = Saving{cost.seconds() - plan.cost.seconds(), more(cost.memory_bytes, plan.cost.memory_bytes),
                         more(cost.disk_bytes(frames), plan.cost.disk_bytes(frames))};
  }
}

} // namespace wry::pipeline
