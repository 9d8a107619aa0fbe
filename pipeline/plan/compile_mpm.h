#pragma once

#include "pipeline/plan/scene_plan.h"
#include "shots/shot.h"
#include "sim/base/result.h"
#include "sim/mpm/mpm_plan.h"

namespace wry::pipeline {

/// The material of a shot as the material point method needs it. Errors: bad_input with the key's line.
Result<mpm::Material> compile_matter(const shots::Material& material);

/// [mpm] as the solver needs it; "auto" becomes a number here. Errors: bad_input when the cell size can be told from
/// nothing.
Result<mpm::MpmSettings> compile_mpm_settings(const shots::Shot& shot);

/// A body of particles ready for the solver.
struct CompiledParticles {
  mpm::MpmBody body;
  BodyReport report;
  std::vector<Asset> assets;         ///< that its matter is made from
  std::vector<Asset> grain_assets;   ///< that only its grains are made from
  std::optional<mpm::Source> source; ///< its body is not set
  std::vector<std::string> warnings;
};

/// Fills a body with particles and gives them their fibres. Errors: bad_input with the body's line; out_of_memory when
/// more particles are asked for than the machine can hold, before any is made.
Result<CompiledParticles> compile_particles(const shots::Shot& shot, const shots::Body& body,
                                            const mpm::MpmSettings& settings);

/// [[fixed]] of a body of particles: the space in which its matter is held. Errors: bad_input for a region that has no
/// shape in space.
Result<mpm::HeldSpace> compile_held_space(const shots::Fixed& fixed);

/// [[drive]] of a body of particles: the space that moves as its keys or its collider say, with the matter in it.
/// Errors: bad_input for a region that has no shape in space, and for springs.
Result<mpm::HeldSpace> compile_driven_space(const shots::Drive& drive,
                                            const std::vector<std::shared_ptr<const scene::Collider>>& colliders);

/// Pairs of bodies whose particles overlap at the start, as warnings with their lines.
std::vector<std::string> overlapping_bodies(const shots::Shot& shot, const mpm::MpmPlan& plan);

} // namespace wry::pipeline
