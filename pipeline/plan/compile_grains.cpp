#include "pipeline/plan/compile_grains.h"

#include <fmt/format.h>

#include "pipeline/assets/mesh_import.h"
#include "pipeline/cache/sha256.h"
#include "pipeline/plan/compile_fem.h"
#include "sim/mpm/matter/orientation.h"

namespace wry::pipeline {

namespace {

GrainShape grain_shape(shots::GrainForm form) {
  switch (form) {
  case shots::GrainForm::rod:
    return GrainShape::rod;
  case shots::GrainForm::straw:
    return GrainShape::straw;
  case shots::GrainForm::card:
    return GrainShape::card;
  case shots::GrainForm::coin:
    return GrainShape::coin;
  case shots::GrainForm::brick:
    return GrainShape::brick;
  case shots::GrainForm::sphere:
    return GrainShape::sphere;
  }
  return GrainShape::rod;
}

/// Sheets have some thickness, so that grains do not lie in the surface that carries them: this share of their length.
constexpr double LEAST_THICKNESS = 0.01;
/// Triangles that are drawn in a frame; a picture of more takes gigabytes.
constexpr double MANY_TRIANGLES = 1e7;

/// Brings a mesh to extents of 1 about 0. Returns the extents that it had [m], none of them 0.
Vec3 fit_to_unit_box(geometry::SurfaceMesh& mesh) {
  const Vec3 low = mesh.vertices.colwise().minCoeff(), high = mesh.vertices.colwise().maxCoeff();
  Vec3 extents = high - low;
  const double longest = extents.maxCoeff();
  mesh.vertices.rowwise() -= 0.5 * (low + high).transpose();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    extents[axis] = std::max(extents[axis], LEAST_THICKNESS * longest);
    mesh.vertices.col(axis) /= extents[axis];
  }
  return extents;
}

Status add_mesh(const shots::SubParticleOptions& asked, CompiledGrains& grains) {
  const shots::Located<std::string>& path = *asked.mesh;
  const Result<std::string> hash = sha256_of_file(*path);
  if (!hash)
    return at_source(path.source, hash.error());
  grains.assets.push_back({*path, *hash});
  MeshImportOptions options;
  options.up = static_cast<geometry::Axis>(*asked.mesh_along);
  options.scene_up = geometry::Axis::z;
  Result<ImportedMesh> imported = import_mesh(*path, options);
  if (!imported)
    return at_source(path.source, imported.error());
  for (const std::string& note : imported->notes)
    grains.notes.push_back("mesh of its grains: " + note);
  const Vec3 own_size = fit_to_unit_box(imported->mesh);
  grains.settings.shape = GrainShape::mesh;
  grains.settings.size = asked.size ? **asked.size : own_size;
  grains.settings.mesh = std::make_shared<const geometry::SurfaceMesh>(std::move(imported->mesh));
  return {};
}

} // namespace

/// Grains of a material that reorients turn with the flow's stretch as well.
Result<CompiledGrains> compile_grains(const shots::SubParticleOptions& asked, const shots::Body& body,
                                      const mpm::Material& material) {
  CompiledGrains compiled;
  mpm::SubParticleSettings& grains = compiled.settings;
  grains.name = *body.name + ".grains";
  grains.look = body.look ? **body.look : std::string();
  grains.per_particle = static_cast<int>(*asked.per_particle);
  grains.size_variation = *asked.size_variation;
  grains.tilt_degrees = *asked.spread_deg;
  grains.seed = static_cast<std::uint64_t>(*asked.seed);
  grains.escape_density = *asked.escape_density;
  grains.capture_density = *asked.capture_density;
  grains.travel = *asked.travel;
  if (material.reorientation)
    grains.jeffery = mpm::jeffery_shape(material.reorientation->length_over_width);
  if (!asked.mesh) {
    grains.shape = grain_shape(*asked.shape);
    grains.size = **asked.size;
    return compiled;
  }
  if (Status status = add_mesh(asked, compiled); !status)
    return status.error();
  return compiled;
}

std::string too_many_triangles(const mpm::SubParticleSettings& grains, double particles) {
  const double triangles =
      grains.mesh ? particles * grains.per_particle * static_cast<double>(grains.mesh->triangles.rows()) : 0.0;
  if (triangles < MANY_TRIANGLES)
    return {};
  return fmt::format("{}: {:.3g} triangles are drawn in every frame ({} for each grain), about {:.2g} GB; a mesh with "
                     "fewer, or fewer grains, is drawn faster",
                     grains.name, triangles, grains.mesh->triangles.rows(), 1e-9 * 108.0 * triangles);
}

} // namespace wry::pipeline
