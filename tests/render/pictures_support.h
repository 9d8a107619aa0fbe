#pragma once

#include "render/mesh_scene.h"
#include "render/renderer.h"

namespace wry::render::testing {

/// A small plan of the built-in looks for one mesh scene.
RenderPlan small_plan(const MeshScene& scene);

} // namespace wry::render::testing
