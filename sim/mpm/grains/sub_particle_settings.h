#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "sim/base/types.h"
#include "sim/geometry/surface_mesh.h"
#include "sim/state/frame.h"

namespace wry::mpm {

/// What decides when grains are brought up to date. Where it is the matter alone, the times are the same for grains of
/// any number or seed.
enum class GrainClock { matter_and_grains, matter };

/// What grains look like, and how they follow the matter that they stand for (spec S10).
struct SubParticleSettings {
  std::string name;                   ///< of their body in frames
  std::string look;                   ///< of their pictures; empty: the body's
  int per_particle = 4;               ///< usual: 4 to 10
  GrainShape shape = GrainShape::rod; ///< how a grain is drawn
  /// Of GrainShape::mesh: extents of 1 about 0, its z along the fibre.
  std::shared_ptr<const geometry::SurfaceMesh> mesh;
  Vec3 size{0.004, 0.004, 0.016};     ///< of a grain along the material's x, y, z [m]; z is the fibre or normal
  double size_variation = 0.2;        ///< standard deviation of the size, relative
  Vec3 second_moment = Vec3::UnitZ(); ///< of their directions in the material's axes: shares that sum to 1
  double tilt_degrees = 6.0;          ///< standard deviation of a grain's direction from the material's z
  std::uint64_t seed = 1;
  double escape_density = 0.005; ///< theta: below this share of the material's density a grain flies by itself
  double capture_density = 0.2;  ///< above it a flying grain is part of the matter again; at least 2 theta
  double travel = 0.25;          ///< cells that a grain may go between two updates; less is more accurate
  GrainClock clock = GrainClock::matter_and_grains;
  double restitution = 0.15, friction = 0.5; ///< of grains that fly, against obstacles
  std::optional<double> jeffery;             ///< l: grains also turn with the flow's stretch; absent: with the matter
};

} // namespace wry::mpm
