#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/isa.h"
#include "sim/base/parallel.h"
#include "sim/mpm/boundaries.h"
#include "sim/mpm/grains/sub_particle_settings.h"
#include "sim/mpm/grid.h"
#include "sim/state/frame.h"
#include "sim/state/state_archive.h"

namespace wry::mpm {

/// What a grain takes in memory, with its place in the order.
inline constexpr std::size_t BYTES_PER_GRAIN = 150;
/// What it takes in a frame: SubParticles::snapshot().
inline constexpr std::size_t BYTES_PER_GRAIN_AND_FRAME = 24 + 16 + 12 + 12 + 4;

/// Where grains start.
struct SubParticleStart {
  const Points& positions;   ///< of the particles [m]
  double particle_volume;    ///< [m^3]
  const Quaternions& frames; ///< of the particles; one row: the same for all
  Vec3 velocity = Vec3::Zero();
  double density = 1000.0; ///< rho_0 [kg/m^3]
};

struct FlowField;
struct GrainKernels;

/// How many grains are where.
struct SubParticleCounts {
  std::size_t carried = 0, flying = 0, resting = 0;
};

/// The grains of a body: points with an orientation that are carried by the grid's velocity, fly by themselves where
/// the matter has torn, and come to rest on obstacles. They do not act on anything.
class SubParticles {
public:
  SubParticles(SubParticleSettings settings, const SubParticleStart& start, Isa isa);

  std::size_t count() const { return m_state.size(); }
  const SubParticleSettings& settings() const { return m_settings; }

  /// Puts grains that start in an obstacle to its face: what a particle stands for may reach into the wall beside it.
  void leave_obstacles(const Boundaries& boundaries, double cell);

  /// A step of the simulation has been made. Returns the time that grains must now be brought forward [s]: when the
  /// fastest may have gone `travel`, and when a frame ends; else 0.
  struct StepSeen {
    double dt = 0.0;           ///< [s]
    double max_speed = 0.0;    ///< of the matter [m/s]
    double max_gradient = 0.0; ///< |L| [1/s]
    bool ends_frame = false;
  };
  double due(const StepSeen& step, const Vec3& gravity, double cell);
  /// Brings grains forward by `span` on a grid (Grid or SnapshotGrid) whose nodes have velocities [m/s] and masses
  /// [kg]. Returns how many grains were moved, once for every part of the span.
  template <class AnyGrid>
  std::size_t update(const AnyGrid& grid, const Boundaries& boundaries, const Vec3& gravity, double cell, double span,
                     const Threads& threads);

  SubParticleCounts counts() const;
  /// Updates made so far, and grains updated in them.
  std::size_t updates() const { return m_updates; }

  /// Channels position, orientation (w, x, y, z), size (3, [m]), velocity,
  /// phase (0 carried, 1 flying, 2 resting).
  FrameBody snapshot() const;
  SceneBody scene_body() const;
  void archive(const std::string& prefix, StateArchive& to) const;
  /// Errors: io naming the array that is missing or does not fit.
  Status restore(const std::string& prefix, const StateArchive& from);

private:
  enum class Phase : std::uint8_t { carried, flying, resting };
  /// Grains of one block of the grid.
  struct Run {
    BlockCoord coord;
    std::size_t begin = 0, end = 0; ///< of m_order
  };

  struct RunReport {
    bool strayed = false; ///< a grain has gone too far from the block
    double fastest = 0.0; ///< of those that fly [m/s]
  };
  /// What moves; in one piece, since grains of a block lie apart in memory.
  struct alignas(128) Grain {
    Vec4 orientation;
    Vec3 position, velocity, spin; ///< [m], [m/s], [rad/s]
  };

  void sort(double cell);
  template <class AnyGrid>
  void advance(const AnyGrid& grid, const BlockIndex& blocks, const Boundaries& boundaries, const Vec3& gravity,
               double cell, double dt, const Threads& threads);
  RunReport update_run(const Run& run, FlowField& field);
  double thinnest() const;
  double radius_of(double size) const;
  void carry(const std::uint32_t* grains, int count, const FlowField& field);
  bool rest(std::size_t grain, const FlowField& field);
  void fly(std::size_t grain, const FlowField& field);
  void meet_obstacles(std::size_t grain, const FlowField& field, WallSet among);

  SubParticleSettings m_settings;
  Isa m_isa;
  const GrainKernels* m_kernels;
  double m_density = 0.0; ///< rho_0 [kg/m^3]
  double m_fastest = 0.0; ///< flying grain at the last update [m/s]
  double m_pending = 0.0; ///< time that has passed since the last update [s]
  double m_gone = 0.0;    ///< cells that the fastest may have gone in it
  double m_turned = 0.0;  ///< dt |L| in it
  std::size_t m_updates = 0;
  bool m_strayed = true; ///< grains must be sorted before the next update
  std::vector<Grain> m_grains;
  std::vector<Phase> m_state;
  std::vector<std::uint8_t> m_blend;  ///< updates over which a captured grain still takes up the matter's velocity
  std::vector<float> m_size;          ///< relative
  std::vector<std::uint32_t> m_order; ///< grains by block
  std::vector<Run> m_runs;
};

} // namespace wry::mpm
