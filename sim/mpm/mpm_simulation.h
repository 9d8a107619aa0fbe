#pragma once

#include <memory>

#include "sim/base/isa.h"
#include "sim/base/result.h"
#include "sim/mpm/grains/grid_snapshot.h"
#include "sim/mpm/mpm_plan.h"
#include "sim/mpm/time_step.h"
#include "sim/state/frame.h"
#include "sim/state/state_archive.h"

namespace wry::mpm {

/// What a step did.
struct StepStats {
  double time = 0.0;                  ///< at its end [s]
  double dt = 0.0;                    ///< [s]
  StepLimit limit = StepLimit::frame; ///< what kept it from being longer
  double given_over_stable = 0.0;     ///< a step given by hand divided by the longest stable one; 0: none was given
  std::size_t particles = 0, blocks = 0;
  bool sorted = false;           ///< particles were sorted before it
  double max_speed = 0.0;        ///< of a particle at its end [m/s]
  double kinetic_energy = 0.0;   ///< of the particles, without their affine part [J]
  int linear_iterations = 0;     ///< of a semi-implicit step
  std::size_t grain_updates = 0; ///< grains brought up to date, once for every part of their way
  double scatter_ms = 0.0, grid_ms = 0.0, gather_ms = 0.0, sort_ms = 0.0, grains_ms = 0.0, total_ms = 0.0;
};

/// Sums over all particles, in doubles.
struct Totals {
  double mass = 0.0;
  Vec3 momentum = Vec3::Zero();
  Vec3 angular_momentum = Vec3::Zero(); ///< about the origin, with the affine part of APIC
  double kinetic_energy = 0.0;          ///< with the affine part
  double elastic_energy = 0.0;
  double gravity_energy = 0.0;
};

/// The material point method on a plan.
class MpmSimulation {
public:
  /// Errors: those of compile_material; bad_input for a body without particles, particles that are nowhere, or a frame
  /// that is no rotation; out_of_memory when more is needed than the machine has.
  static Result<std::unique_ptr<MpmSimulation>> create(MpmPlan plan, int threads, Isa isa);
  virtual ~MpmSimulation() = default;

  /// One step that does not go past `end`, and of which a whole number is left to `end`. Errors: solver with time,
  /// particle, place and wave speed when a particle's deformation is lost.
  virtual Result<StepStats> step(double end) = 0;
  virtual double time() const = 0;
  virtual std::size_t particle_count() const = 0;
  /// Longest stable step from here, and what bounds it.
  virtual StepBound bound() const = 0;
  virtual Totals totals() const = 0;

  virtual SceneStatic scene_static() const = 0;
  virtual Frame snapshot(int number) const = 0;
  /// What carried grains since this was last asked, where settings.keep_fields says so; else nothing.
  virtual std::vector<GrainUpdate> take_fields() = 0;
  /// Brings the grains, and nothing else, forward as these say: to the same bits as when they were kept. Errors:
  /// bad_input where they are not those of these bodies.
  virtual Status replay(const std::vector<GrainUpdate>& updates) = 0;
  virtual StateArchive archive() const = 0;
  virtual Status restore(const StateArchive& archive) = 0;
  virtual std::size_t memory_bytes() const = 0;
};

/// What the particles of a body carry, for `plan`.
struct ParticleCost {
  std::size_t bytes = 0;
  std::string channels; ///< "position 12, velocity 12, ..."
};
Result<ParticleCost> particle_cost(const Material& material, Precision precision);

} // namespace wry::mpm
