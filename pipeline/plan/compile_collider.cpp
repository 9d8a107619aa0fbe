#include "pipeline/plan/compile_collider.h"

#include <fmt/format.h>

#include "pipeline/assets/mesh_import.h"
#include "pipeline/assets/mesh_sequence_import.h"
#include "pipeline/assets/motion_import.h"
#include "pipeline/cache/sha256.h"
#include "pipeline/plan/compile_fem.h"
#include "pipeline/plan/mesh_body.h"

namespace wry::pipeline {

namespace {

/// Compiles one collider, part by part.
class ColliderCompiler {
public:
  ColliderCompiler(const shots::Collider& asked, const shots::ShotSettings& shot)
      : m_asked(asked)
      , m_shot(shot)
      , m_up(*shot.up) {}

  Result<CompiledCollider> compile() {
    m_collider.name = *m_asked.name;
    m_collider.friction = *m_asked.friction;
    m_collider.contact = static_cast<scene::ColliderContact>(*m_asked.contact);
    m_collider.look = m_asked.look ? **m_asked.look : std::string();
    m_collider.shown = *m_asked.show;
    if (Status status = std::visit([this](const auto& shape) { return add(shape); }, m_asked.shape); !status)
      return status.error();
    if (*m_asked.motion.from == shots::MotionFrom::keys) {
      Result<scene::Motion> motion = compile_motion(m_asked.motion);
      if (!motion)
        return motion.error();
      m_collider.motion = std::move(*motion);
    }
    m_compiled.collider = std::make_shared<const scene::Collider>(std::move(m_collider));
    return std::move(m_compiled);
  }

private:
  Status add(const shots::PlaneShape& plane) {
    m_collider.shape = scene::PlaneObstacle{*plane.point, plane.normal->normalized()};
    return {};
  }

  Status add(const shots::OpenBoxShape& asked) {
    const Result<scene::Similarity> placed = placement(*asked.size);
    if (!placed)
      return placed.error();
    scene::BoxObstacle box;
    box.centre = placed->translation;
    box.axes = placed->rotation;
    box.size = placed->scale * *asked.size;
    box.wall = asked.wall ? placed->scale * **asked.wall : 0.0;
    for (const shots::Located<std::string>& side : asked.open) {
      const int face = 2 * ((*side)[1] - 'x') + ((*side)[0] == '+' ? 1 : 0);
      box.open[static_cast<std::size_t>(face)] = true;
    }
    m_collider.shape = box;
    return {};
  }

  Status add(const shots::SphereShape& asked) {
    const Result<scene::Similarity> placed = placement(Vec3::Constant(2.0 * *asked.radius));
    if (!placed)
      return placed.error();
    m_collider.shape = scene::SphereObstacle{placed->translation, placed->scale * *asked.radius};
    return {};
  }

  Status add(const shots::CylinderShape& asked) {
    const Result<scene::Similarity> placed = placement(Vec3(2.0 * *asked.radius, *asked.height, 2.0 * *asked.radius));
    if (!placed)
      return placed.error();
    const Vec3 half(0.0, 0.5 * *asked.height, 0.0);
    m_collider.shape =
        scene::CylinderObstacle{placed->apply(-half), placed->apply(half), placed->scale * *asked.radius};
    return {};
  }

  Status add(const shots::ColliderMeshShape& asked) {
    const Result<std::string> hash = sha256_of_file(*asked.path);
    if (!hash)
      return at_source(asked.path.source, hash.error());
    m_compiled.assets.push_back({*asked.path, *hash});
    MeshImportOptions options;
    options.metres_per_unit = *m_asked.metres_per_unit;
    options.up = static_cast<geometry::Axis>(m_asked.up ? **m_asked.up : m_up);
    options.scene_up = static_cast<geometry::Axis>(m_up);
    options.node = asked.node ? **asked.node : std::string();
    Result<ImportedMesh> imported = import_mesh(*asked.path, options);
    if (!imported)
      return at_source(asked.node ? asked.node->source : asked.path.source, imported.error());
    m_compiled.notes = imported->notes;
    const Result<scene::Similarity> placed = placement(imported->report.extent());
    if (!placed)
      return placed.error();
    scene::apply(*placed, imported->mesh.vertices);
    if (*m_asked.motion.from == shots::MotionFrom::file) {
      if (Status status = move_as_in_file(asked, options, *placed); !status)
        return status;
    }
    scene::MeshObstacle mesh;
    mesh.closed = imported->report.is_closed();
    mesh.thickness = *asked.thickness;
    if (asked.sequence) {
      if (Status status = follow_sequence(asked, options, *placed, imported->mesh, mesh); !status)
        return at_source(asked.sequence->source, status.error());
    }
    mesh.mesh = std::make_shared<const geometry::SurfaceMesh>(std::move(imported->mesh));
    m_collider.shape = std::move(mesh);
    return {};
  }

  /// Where the mesh's vertices are over the shot's frames.
  Status follow_sequence(const shots::ColliderMeshShape& asked, const MeshImportOptions& options,
                         const scene::Similarity& placed, geometry::SurfaceMesh& mesh, scene::MeshObstacle& obstacle) {
    MeshSequenceSource source;
    source.mesh = *asked.path;
    source.sequence = **asked.sequence;
    source.placements = {{options.metres_per_unit, scene::up_rotation(options.up, options.scene_up), Vec3::Zero()},
                         placed};
    source.first_frame = m_shot.frames->first();
    source.last_frame = m_shot.frames->last();
    Result<ImportedMeshSequence> imported = import_mesh_sequence(source, mesh.vertices);
    if (!imported)
      return imported.error();
    for (const std::string& file : imported->files) {
      const Result<std::string> hash = sha256_of_file(file);
      if (!hash)
        return hash.error();
      m_compiled.assets.push_back({file, *hash});
    }
    auto sequence = std::make_shared<scene::MeshSequence>();
    sequence->samples = std::move(imported->samples);
    sequence->first_time = (imported->first_frame - source.first_frame) / *m_shot.fps;
    sequence->interval = imported->frames_per_sample / *m_shot.fps;
    mesh.vertices = sequence->at(0.0);
    obstacle.sequence = std::move(sequence);
    return {};
  }

  /// The motion of the file, seen through the placement that its mesh went through.
  Status move_as_in_file(const shots::ColliderMeshShape& asked, const MeshImportOptions& options,
                         const scene::Similarity& placed) {
    const shots::Source& where = m_asked.motion.from.source;
    if (!asked.node)
      return at_source(where, make_error(ErrorCode::bad_input, "name the node whose motion it takes: node = \"...\""));
    Result<ImportedMotion> imported = import_motion(*asked.path, options);
    if (!imported)
      return at_source(where, imported.error());
    const auto place = [&](const scene::Pose& pose) {
      scene::Pose moved;
      moved.rotation = placed.rotation * pose.rotation * placed.rotation.transpose();
      moved.translation = placed.apply(pose.translation);
      return moved;
    };
    imported->rest = place(imported->rest);
    for (scene::PoseSample& sample : imported->samples)
      sample.pose = place(sample.pose);
    Result<scene::Motion> motion = imported->relative_motion();
    if (!motion)
      return at_source(where, motion.error());
    m_collider.motion = std::move(*motion);
    return {};
  }

  Result<scene::Similarity> placement(const Vec3& extent) const {
    const Result<scene::Similarity> placed = scene::placement_similarity(compile_placement(m_asked, m_up), extent);
    if (!placed)
      return at_source(m_asked.source, placed.error());
    return placed;
  }

  const shots::Collider& m_asked;
  const shots::ShotSettings& m_shot;
  shots::Axis m_up;
  scene::Collider m_collider;
  CompiledCollider m_compiled;
};

} // namespace

Result<CompiledCollider> compile_collider(const shots::Collider& collider, const shots::ShotSettings& shot) {
  return ColliderCompiler(collider, shot).compile();
}

Error cannot_follow(const std::string& collider) {
  return make_error(ErrorCode::bad_input,
                    "collider '{}' deforms by its sequence, and a drive moves nodes as a whole; give the drive keys",
                    collider);
}

Result<scene::Motion> compile_motion(const shots::Motion& motion) {
  scene::MotionKeys keys;
  keys.pivot = *motion.pivot;
  keys.ease = *motion.ease == shots::Ease::smooth ? scene::Ease::smooth : scene::Ease::linear;
  for (const shots::MotionKey& key : motion.keys)
    keys.keys.push_back({*key.time, key.translate, key.axis, key.degrees});
  Result<scene::Motion> made = scene::Motion::along_keys(keys);
  if (!made)
    return at_source(motion.keys.front().source, made.error());
  return made;
}

} // namespace wry::pipeline
