#include "sim/fem/state_report.h"

#include <fmt/format.h>

namespace wry::fem {

Trial trial_at_rest_in(const FemState& state) {
  Trial trial;
  trial.positions = state.positions;
  trial.velocities = state.velocities;
  trial.angular = state.angular;
  trial.increments = Points::Zero(state.angular.rows(), 3);
  return trial;
}

void add_energies(const FemScene& scene, const FemState& state, StepStats& stats) {
  const Trial trial = trial_at_rest_in(state);
  const FemModel& model = scene.model;
  for (int node = 0; node < model.layout.node_count(); ++node) {
    stats.kinetic_energy += 0.5 * model.mass[node] * state.velocities.row(node).squaredNorm();
    if (model.rotary_mass[node] > 0.0)
      stats.kinetic_energy += 0.5 * model.rotary_mass[node] * state.angular.row(node).squaredNorm();
    stats.gravity_energy -= model.mass[node] * state.positions.row(node).dot(model.gravity);
  }
  for (const std::unique_ptr<BodyElements>& elements : scene.elements) {
    const double total = elements->energy({}, trial);
    const double elastic = elements->has_curvature() ? elements->elastic_energy(trial) : total;
    stats.elastic_energy += elastic;
    stats.curvature_energy += total - elastic;
  }
}

std::string describe_inverted(const FemPlan& plan, const FemScene& scene, const FemState& state) {
  for (std::size_t i = 0; i < plan.bodies.size(); ++i) {
    const FemBody& body = plan.bodies[i];
    if (is_plate(body.element))
      continue;
    for (Eigen::Index t = 0; t < body.mesh->tets.rows(); ++t) {
      Mat3 edges;
      for (int k = 0; k < 3; ++k)
        edges.col(k) = (state.positions.row(scene.model.bodies[i].first_node + body.mesh->tets(t, k + 1)) -
                        state.positions.row(scene.model.bodies[i].first_node + body.mesh->tets(t, 0)))
                           .transpose();
      if (const double volume = edges.determinant() / 6.0; !(volume > 0.0))
        return fmt::format("; body '{}': tet {} (vertices {} {} {} {}) has the volume {:.3g} m^3: a material with a "
                           "logarithm of it cannot come back from there",
                           body.name, t, body.mesh->tets(t, 0), body.mesh->tets(t, 1), body.mesh->tets(t, 2),
                           body.mesh->tets(t, 3), volume);
    }
  }
  return {};
}

} // namespace wry::fem
