#pragma once

#include "render/mesh_scene.h"
#include "render/renderer.h"

namespace wry::render::testing {

/// A small plan of the built-in looks for one mesh scene.
RenderPlan small_plan(const MeshScene& scene);

/// A ball in a world that is equally white on all sides, without any light.
RenderPlan white_furnace(const MeshScene& ball, const Look& look);

/// A look that keeps no light for itself.
Look white(float roughness, float metallic);

} // namespace wry::render::testing
