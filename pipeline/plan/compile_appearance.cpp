#include "pipeline/plan/compile_appearance.h"

#include <algorithm>
#include <variant>

#include "pipeline/assets/mesh_import.h"
#include "pipeline/plan/compile_fem.h"

namespace wry::pipeline {

namespace {

Result<ImportedMesh> import_again(const shots::ColliderMeshShape& shape, const shots::Collider& collider,
                                  shots::Axis up) {
  MeshImportOptions options;
  options.metres_per_unit = *collider.metres_per_unit;
  options.up = static_cast<geometry::Axis>(collider.up ? **collider.up : up);
  options.scene_up = static_cast<geometry::Axis>(up);
  options.node = shape.node ? **shape.node : std::string();
  Result<ImportedMesh> imported = import_mesh(*shape.path, options);
  if (!imported)
    return at_source(shape.path.source, imported.error());
  return imported;
}

Eigen::Index drawn_triangles(const SceneStatic& scene, const std::string& name) {
  const auto found =
      std::find_if(scene.bodies.begin(), scene.bodies.end(), [&](const SceneBody& body) { return body.name == name; });
  return found != scene.bodies.end() ? found->triangles.rows() : 0;
}

} // namespace

const shots::Look* look_with_own_materials(const shots::Shot& shot,
                                           const std::optional<shots::Located<std::string>>& name) {
  const shots::Look* look = name ? shot.find_look(**name) : nullptr;
  return look != nullptr && *look->own_materials ? look : nullptr;
}

Result<std::map<std::string, std::shared_ptr<const render::MeshAppearance>>>
compile_appearances(const shots::Shot& shot, const SceneStatic& scene) {
  std::map<std::string, std::shared_ptr<const render::MeshAppearance>> appearances;
  for (const shots::Collider& collider : shot.colliders) {
    const shots::Look* look = look_with_own_materials(shot, collider.look);
    const Eigen::Index triangles = drawn_triangles(scene, *collider.name);
    if (look == nullptr || triangles == 0)
      continue;
    const auto* shape = std::get_if<shots::ColliderMeshShape>(&collider.shape);
    if (shape == nullptr)
      return make_error(ErrorCode::bad_input,
                        "{}: collider {} comes from no mesh file, so it has no materials of its own",
                        look->own_materials.source.text(), *collider.name);
    Result<ImportedMesh> imported = import_again(*shape, collider, *shot.shot.up);
    if (!imported)
      return imported.error();
    if (!imported->appearance || imported->mesh.triangles.rows() != triangles)
      return make_error(ErrorCode::bad_input, "{}: {} has no materials{}", look->own_materials.source.text(),
                        *shape->path,
                        imported->appearance ? " for the frames in the cache, which were made from another file" : "");
    appearances[*collider.name] = std::make_shared<render::MeshAppearance>(std::move(*imported->appearance));
  }
  return appearances;
}

} // namespace wry::pipeline
