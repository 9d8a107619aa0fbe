#pragma once

#include <map>
#include <memory>
#include <string>

#include "render/mesh_appearance.h"
#include "shots/shot.h"
#include "sim/base/result.h"
#include "sim/state/frame.h"

namespace wry::pipeline {

/// The materials and pictures of the mesh files of colliders whose look says own_materials, by collider. Errors: those
/// of import_mesh(); bad_input with the look's line for a simulated body (its surface is made anew and has no texture
/// coordinates) or a shape that comes from no file.
Result<std::map<std::string, std::shared_ptr<const render::MeshAppearance>>>
compile_appearances(const shots::Shot& shot, const SceneStatic& scene);

} // namespace wry::pipeline
