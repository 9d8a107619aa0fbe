#pragma once

#include <memory>

#include "sim/fem/terms/energy_term.h"

namespace wry::fem {

/// 1/2 (v - v~)^T M (v - v~), M lumped.
std::unique_ptr<EnergyTerm> make_inertia(const FemModel& model, const ContactState& contact);
/// 1/2 (omega - omega~)^T M_j (omega - omega~); nullptr when no material has rotary inertia.
std::unique_ptr<EnergyTerm> make_rotary_inertia(const FemModel& model, const ContactState& contact);
/// - beta v^T M g; nullptr without gravity.
std::unique_ptr<EnergyTerm> make_gravity(const FemModel& model, const ContactState& contact);
/// Springs that pull nodes along motions; nullptr without such drives.
std::unique_ptr<EnergyTerm> make_drive_springs(const FemModel& model, const ContactState& contact);
/// beta/2 c v^T M v; nullptr when no material has mass-proportional damping.
std::unique_ptr<EnergyTerm> make_mass_damping(const FemModel& model, const ContactState& contact);
/// - beta v . f - a . m of given forces and torques; nullptr without loads.
std::unique_ptr<EnergyTerm> make_loads(const FemModel& model, const ContactState& contact);
/// The barrier of eq 19 between nodes and planes; nullptr without planes.
std::unique_ptr<EnergyTerm> make_plane_barrier(const FemModel& model, const ContactState& contact);
/// Coulomb friction on planes, smoothed below the friction velocity, with lagged normal forces; nullptr when no plane
/// has friction.
std::unique_ptr<EnergyTerm> make_plane_friction(const FemModel& model, const ContactState& contact);

/// The barrier of eq 19 between primitives of bodies and obstacles, with steps limited by continuous collision
/// detection; nullptr when no such pair may touch.
std::unique_ptr<EnergyTerm> make_pair_barrier(const FemModel& model, const ContactState& contact);
/// Coulomb friction of the same pairs; nullptr when none has friction.
std::unique_ptr<EnergyTerm> make_pair_friction(const FemModel& model, const ContactState& contact);

/// How far a node, with what a plate is thick there, is above a plane [m].
double plane_gap(const FemModel& model, const scene::PlaneCollider& plane, const Points& positions, int node);

/// The least gap between any free node and any plane, and how many gaps are below d-hat.
struct PlaneGaps {
  double least = 0.0; ///< [m]; infinity when there is nothing to touch
  int active = 0;
};
/// Of one body, or of all when `body` is negative.
PlaneGaps measure_plane_gaps(const FemModel& model, const ContactState& contact, const Points& positions, int body);

} // namespace wry::fem
