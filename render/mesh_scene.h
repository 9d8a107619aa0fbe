#pragma once

#include <string>

#include "render/subject_bounds.h"
#include "sim/geometry/surface_mesh.h"
#include "sim/state/frame.h"

namespace wry::render {

/// A bare mesh as a scene of one body that does not move, with its one frame and bounds: a turntable needs no shot.
struct MeshScene {
  SceneStatic scene;
  Frame frame;
  SubjectBounds bounds;
};

/// `look`: name of a look of the plan. Vertex attributes of the mesh become channels that heat views can show.
MeshScene make_mesh_scene(const geometry::SurfaceMesh& mesh, const std::string& name, const std::string& look);

} // namespace wry::render
