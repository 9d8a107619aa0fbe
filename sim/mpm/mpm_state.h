#pragma once

#include <cstdint>
#include <vector>

#include "sim/mpm/mpm_plan.h"
#include "sim/mpm/particle_sort.h"
#include "sim/state/frame.h"
#include "sim/state/state_archive.h"

namespace wry::mpm {

/// A body while it runs: its particles, and its material in the scalar that they have.
template <class Scalar> struct BodyState {
  CompiledMaterial compiled;
  MaterialConstants<Scalar> constants;
  MaterialKernels<Scalar> kernels;
  Scalar mass = 0;   ///< of a particle [kg]
  Scalar volume = 0; ///< of a particle at rest [m^3]
};

/// All that changes. sets[b] are the particles of plan.bodies[b].
template <class Scalar> struct MpmState {
  double time = 0.0; ///< [s]
  std::vector<SortedSet<Scalar>> sets;
  std::vector<double> stiffness_factor; ///< per body
  double max_speed = 0.0;               ///< of a particle [m/s]
  double max_gradient = 0.0;            ///< of |L| [1/s]
  bool strayed = false;                 ///< particles must be sorted before the next scatter
  std::vector<std::int64_t> emitted;    ///< per source: how often it has added its particles
};

/// Gives the particles of a body whose identities begin at `first_identity` what they start with.
template <class Scalar> void start_particles(const MpmBody& body, std::int64_t first_identity, SortedSet<Scalar>& set);

/// The state as named arrays, with every bit.
template <class Scalar> StateArchive archive_state(const MpmState<Scalar>& state);
/// `state` has the right bodies. Errors: io naming the array that is missing or does not fit.
template <class Scalar> Status restore_state(const StateArchive& archive, MpmState<Scalar>& state);

/// Where a particle is [m].
template <class Scalar>
Vec3 world_position(const ParticleSet<Scalar>& particles, const BlockRun& run, std::size_t place, double cell);

/// The body's channels of a frame, particles in the order of their identities.
template <class Scalar> FrameBody snapshot_body(const MpmBody& body, const SortedSet<Scalar>& set, double cell);

} // namespace wry::mpm
