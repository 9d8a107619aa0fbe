#pragma once

#include <string>
#include <vector>

#include "sim/base/types.h"
#include "sim/fem/linear/dof_layout.h"
#include "sim/scene/collider.h"

namespace wry::fem {

/// The nodes of one body among all nodes of the simulation.
struct BodyNodes {
  std::string name;
  int first_node = 0;
  int node_count = 0;
  bool micropolar = false;
};

/// What the energy terms need to know of a scene; constant in time.
struct FemModel {
  DofLayout layout;
  std::vector<BodyNodes> bodies;
  std::vector<int> body_of_node;
  std::vector<double> mass;        ///< per node [kg]
  std::vector<double> rotary_mass; ///< per node: integral of j0 [kg m^2]; zero where there is none
  std::vector<scene::PlaneCollider> planes;
  Vec3 gravity = Vec3::Zero();
  double friction_velocity = 1e-3; ///< [m/s]
  bool any_micropolar = false;
  bool any_rotary = false;
};

/// What contact terms share; adapts to the scene between steps.
struct ContactState {
  double distance = 0.0;         ///< d-hat [m]
  std::vector<double> stiffness; ///< kappa of each body [N/m]
  std::vector<char> ignored;     ///< per node: held in place, so no obstacle can push it
};

/// The time discretisation of one solve: x = base_positions + beta v, a = base_increments + beta omega, and inertia is
/// measured from (base_velocities, base_angular). Backward Euler has beta = dt, bases of the step's start and no base
/// increment.
struct Stage {
  double beta = 0.0; ///< [s]
  double dt = 0.0;   ///< of the whole step [s]
  double time = 0.0; ///< at which the stage's state holds [s]
  Points base_positions;
  Points base_increments; ///< empty: zero
  Points base_velocities;
  Points base_angular;    ///< empty without microrotations
  Points start_positions; ///< at the start of the step, from which friction measures slip
};

/// A point of the minimisation, all fields of all nodes.
struct Trial {
  Points velocities;
  Points angular;    ///< omega [1/s]; empty without microrotations
  Points positions;  ///< x of the velocities
  Points increments; ///< a = base + beta omega; empty without microrotations
};

} // namespace wry::fem
