#include "sim/fem/reactions.h"

#include <Eigen/LU>

#include "sim/base/rotation.h"
#include "sim/fem/terms/energy_term.h"

namespace wry::fem {

Reactions measure_reactions(const FemModel& model, const std::vector<EnergyTerm*>& terms, const Boundary& boundary,
                            const Stage& stage, const Trial& trial) {
  const DofLayout& layout = model.layout;
  const int count = layout.node_count();
  std::vector<double> gradient(layout.dof_count(), 0.0);
  for (const EnergyTerm* term : terms) {
    // Springs are what is asked for; the inertia of given nodes comes from their motion, not from the integrator.
    if (term->name() != "drive_springs" && term->name() != "inertia" && term->name() != "rotary_inertia")
      term->add_gradient(stage, trial, gradient);
  }
  std::vector<char> sprung(static_cast<std::size_t>(count), 0);
  for (const DriveSpring& spring : model.springs.nodes)
    sprung[spring.node] = 1;
  const MotionOfNodes motion = boundary.accelerations(stage.time, stage.dt);
  Reactions reactions;
  reactions.forces = Points::Zero(count, 3);
  if (model.any_micropolar)
    reactions.torques = Points::Zero(count, 3);
  for (int node = 0; node < count; ++node) {
    const std::size_t dof = layout.dof(node);
    const auto demand = [&](int offset) { return Vec3(Eigen::Map<const Vec3>(&gradient[dof + offset]) / stage.beta); };
    if (boundary.held()[dof])
      reactions.forces.row(node) = demand(0) + model.mass[node] * motion.linear.row(node).transpose();
    else if (sprung[node])
      reactions.forces.row(node) =
          demand(0) +
          model.mass[node] / stage.beta * (trial.velocities.row(node) - stage.base_velocities.row(node)).transpose();
    if (layout.dofs(node) != 6 || !(boundary.held()[dof + 3] || sprung[node]))
      continue;
    // The gradient by the increment is D^T times the torque (spec §1).
    const Vec3 a = trial.increments.row(node);
    const Mat3 D = (Mat3::Identity() + 0.5 * cross_matrix(a)) / (1.0 + 0.25 * a.squaredNorm());
    const Vec3 torque = D.transpose().inverse() * demand(3);
    const Vec3 spin = boundary.held()[dof + 3]
                          ? Vec3(motion.angular.row(node))
                          : Vec3((trial.angular.row(node) - stage.base_angular.row(node)) / stage.beta);
    reactions.torques.row(node) = torque + model.rotary_mass[node] * spin;
  }
  return reactions;
}

} // namespace wry::fem
