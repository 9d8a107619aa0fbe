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
/// The barrier of eq 19 between nodes and planes; nullptr without planes.
std::unique_ptr<EnergyTerm> make_plane_barrier(const FemModel& model, const ContactState& contact);
/// Coulomb friction on planes, smoothed below the friction velocity, with lagged normal forces; nullptr when no plane
/// has friction.
std::unique_ptr<EnergyTerm> make_plane_friction(const FemModel& model, const ContactState& contact);

/// The least gap between any free node and any plane, and how many gaps are below d-hat.
struct PlaneGaps {
  double least = 0.0; ///< [m]; infinity when there is nothing to touch
  int active = 0;
};
/// Of one body, or of all when `body` is negative.
PlaneGaps measure_plane_gaps(const FemModel& model, const ContactState& contact, const Points& positions, int body);

} // namespace wry::fem
