#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "render/mesh_appearance.h"
#include "shots/shot.h"
#include "sim/base/result.h"
#include "sim/state/frame.h"

namespace wry::pipeline {

/// The look of that name when it says own_materials, else nullptr.
const shots::Look* look_with_own_materials(const shots::Shot& shot,
                                           const std::optional<shots::Located<std::string>>& name);

/// The materials and pictures of the mesh files of colliders whose look says own_materials, by collider. Errors: those
/// of import_mesh(); bad_input with the look's line for a shape that comes from no file. Those of simulated bodies:
/// DrawnSurfaces.
Result<std::map<std::string, std::shared_ptr<const render::MeshAppearance>>>
compile_appearances(const shots::Shot& shot, const SceneStatic& scene);

} // namespace wry::pipeline
