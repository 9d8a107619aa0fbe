#pragma once

#include <string_view>
#include <vector>

#include "sim/fem/fem_scene.h"
#include "sim/state/frame.h"
#include "sim/state/state_archive.h"

namespace wry::fem {

/// The mutable state of the solids, in the solver's order of nodes. The rotations of the quadrature points, which are
/// state too, live in the element groups.
struct FemState {
  double time = 0.0;     ///< [s]
  Points positions;      ///< [m]
  Points velocities;     ///< [m/s]
  Points angular;        ///< omega [1/s]; empty without microrotations
  Quaternions rotations; ///< nodal microrotations; empty without
};

/// A copy of all stored rotations, to come back to.
class RotationHistory {
public:
  RotationHistory() = default;
  RotationHistory(const Quaternions& rotations, const std::vector<std::unique_ptr<BodyElements>>& elements);
  /// Does nothing when made empty.
  void restore(Quaternions& rotations, const std::vector<std::unique_ptr<BodyElements>>& elements) const;

private:
  Quaternions m_rotations;
  std::vector<AlignedVector<double>> m_points; ///< per body
};

/// The state at the start of the plan.
FemState initial_state(const FemPlan& plan, const FemScene& scene);

/// State, including the rotations of quadrature points, as named arrays in the order of the mesh.
StateArchive archive_state(const FemScene& scene, const FemState& state);
/// Errors: io naming the array that is missing or does not fit.
Status restore_state(const StateArchive& archive, FemScene& scene, FemState& state);

/// The array of that name if it has that many entries, else nullptr.
const NamedArray* find_array(const StateArchive& archive, std::string_view name, std::size_t entries);

/// Bodies as they rest, with their boundary triangles, in the order of the mesh.
SceneStatic describe_bodies(const FemPlan& plan);

/// The channels of one frame; `energies` per body and element [J].
Frame take_snapshot(const FemPlan& plan, const FemScene& scene, const FemState& state,
                    const std::vector<std::vector<double>>& energies, int number);

/// A channel of energies per element [J], as density [J/m^3].
void add_energy_density(const char* name, const FemScene& scene, std::size_t body, const std::vector<double>& energies,
                        Frame& frame);

/// Channels "reaction_force" and "reaction_torque" per vertex, zero when there was no step yet.
void add_reactions(const FemScene& scene, const Points& forces, const Points& torques, Frame& frame);

} // namespace wry::fem
