#pragma once

#include "pipeline/plan/scene_plan.h"
#include "shots/shot.h"
#include "sim/base/result.h"
#include "sim/mpm/grains/sub_particle_settings.h"
#include "sim/mpm/material.h"

namespace wry::pipeline {

/// The grains of a body, ready for the solver.
struct CompiledGrains {
  mpm::SubParticleSettings settings;
  std::vector<Asset> assets;
  std::vector<std::string> notes; ///< on the mesh that they are drawn as
};

/// sub_particles = { ... } of a body made of this material. Errors, with the key's line: those of import_mesh().
Result<CompiledGrains> compile_grains(const shots::SubParticleOptions& asked, const shots::Body& body,
                                      const mpm::Material& material);

/// A warning where so many grains of a mesh would be slow to draw, else empty.
std::string too_many_triangles(const mpm::SubParticleSettings& grains, double particles);

} // namespace wry::pipeline
