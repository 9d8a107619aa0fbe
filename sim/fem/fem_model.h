#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/base/types.h"
#include "sim/fem/linear/dof_layout.h"
#include "sim/scene/collider.h"
#include "sim/scene/motion.h"

namespace wry::fem {

/// The nodes of one body among all nodes of the simulation.
struct BodyNodes {
  std::string name;
  int first_node = 0;
  int node_count = 0;
  bool micropolar = false;
  bool plate = false;
  /// A midpoint of quadratic elements, whose rotation is not an unknown but follows those of its neighbours.
  struct Midpoint {
    int node = 0;
    int ends[2] = {0, 0};
  };
  std::vector<Midpoint> midpoints;
};

/// A node that a spring pulls along a motion.
struct DriveSpring {
  int node = 0;
  int motion = 0;                ///< index into DriveSprings::motions
  Vec3 rest = Vec3::Zero();      ///< where the motion starts from [m]
  double stiffness = 0.0;        ///< of the position [N/m]
  double turning = 0.0;          ///< of the microrotation [N m]
  bool scales_with_mass = false; ///< a penalty: grows as steps get shorter
};

/// Drives by springs; which of them pull changes between steps.
struct DriveSprings {
  std::vector<scene::Motion> motions;
  std::vector<double> until; ///< per motion: released after this time [s]; infinity: never
  std::vector<DriveSpring> nodes;
};

/// Forces and torques on nodes that do not depend on where they are.
struct NodeLoad {
  std::vector<int> nodes;
  std::vector<double> shares;              ///< per node: of a volume [m^3], an area [m^2], or of the whole
  std::function<Vec3(double time)> force;  ///< per share [N, N/m^2, N/m^3]; empty: none
  std::function<Vec3(double time)> torque; ///< per share [N m, ...]; empty: none
};

/// What the energy terms need to know of a scene; constant in time.
struct FemModel {
  DofLayout layout;
  std::vector<BodyNodes> bodies;
  std::vector<int> body_of_node;
  std::vector<double> mass;           ///< per node [kg]
  std::vector<double> rotary_mass;    ///< per node: integral of j0 [kg m^2]; zero where there is none
  std::vector<double> damping;        ///< per node: mass-proportional [1/s]; empty: none
  std::vector<double> half_thickness; ///< per node: what a plate is thick on either side [m]; empty: no plates
  DriveSprings springs;
  std::vector<NodeLoad> loads;
  const Quaternions* rotations = nullptr; ///< the nodes' stored rotations, which the simulation keeps in place
  std::vector<scene::PlaneCollider> planes;
  Vec3 gravity = Vec3::Zero();
  double friction_velocity = 1e-3; ///< [m/s]
  bool any_micropolar = false;
  bool any_rotary = false;
};

class ContactSystem;

/// What contact terms share; adapts to the scene between steps.
struct ContactState {
  double distance = 0.0;           ///< d-hat [m]
  std::vector<double> stiffness;   ///< kappa of each body [N/m]
  std::vector<char> ignored;       ///< per node: held in place, so no obstacle can push it
  ContactSystem* system = nullptr; ///< pairs of primitives; nullptr when nothing but planes can touch
};

/// The time discretisation of one solve: x = base_positions + beta v, a = base_increments + beta omega, and inertia is
/// measured from (base_velocities, base_angular). Backward Euler has beta = dt, bases of the step's start and no base
/// increment. Methods of second order turn the stored rotations ahead to where they are expected; increments then
/// count from there.
struct Stage {
  double beta = 0.0;       ///< [s]
  double dt = 0.0;         ///< of the whole step [s]
  double time = 0.0;       ///< at which the stage's state holds [s]
  double start_time = 0.0; ///< of the step: what moves by itself sets out from where it was then [s]
  /// Rotation vectors instead of Cayley's increments (rotation_update.h); base_increments are empty then.
  bool exponential = false;
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
  Points increments; ///< Cayley's: a = base + beta omega, or of that turn; empty without microrotations
};

} // namespace wry::fem
