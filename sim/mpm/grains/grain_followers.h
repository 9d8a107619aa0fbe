#pragma once

#include <vector>

#include "sim/mpm/grains/grid_snapshot.h"
#include "sim/mpm/grains/sub_particles.h"
#include "sim/mpm/mpm_plan.h"

namespace wry::mpm {

/// The grains of all bodies that have some, in their order, and what carried them where that is kept.
class GrainFollowers {
public:
  /// Puts grains in the particles that bodies start with, outside of obstacles.
  GrainFollowers(const MpmPlan& plan, const Boundaries& boundaries, Isa isa);

  /// A step that began at `time` has been made on this grid. Returns how many grains were moved for it.
  template <class Scalar>
  std::size_t follow(const Grid<Scalar>& grid, const Boundaries& boundaries, double time,
                     const SubParticles::StepSeen& step, const Threads& threads);
  /// See MpmSimulation.
  std::vector<GrainUpdate> take_fields();
  Status replay(const std::vector<GrainUpdate>& updates, Boundaries& boundaries, const Threads& threads);

  void add_to(SceneStatic& scene) const;
  void add_to(Frame& frame) const;
  void archive(StateArchive& to) const;
  /// Errors: io naming the array that is missing or does not fit.
  Status restore(const StateArchive& from);
  std::size_t memory_bytes() const;

private:
  Vec3 m_gravity;
  double m_cell = 0.0;
  enum class Fields { dropped, kept } m_keeps = Fields::dropped;
  std::vector<SubParticles> m_grains;
  std::vector<GrainUpdate> m_fields; ///< that have not been taken yet
};

} // namespace wry::mpm
