#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pipeline/plan/scene_plan.h"
#include "shots/shot.h"
#include "sim/base/result.h"
#include "sim/geometry/tet_mesh.h"
#include "sim/scene/transform.h"

namespace wry::pipeline {

/// A body ready for the solver: placed, meshed, checked.
struct MeshedBody {
  std::shared_ptr<const geometry::TetMesh> mesh;
  BodyReport report;
  std::vector<Asset> assets;
};

/// How a shot places a shape or mesh.
scene::Placement compile_placement(const shots::Placed& placed, shots::Axis up);

/// Makes a body's rest mesh: imports or generates its surface, sizes and places it, fills or hollows it, and holds it
/// against the quality gate. Errors: bad_input with the body's line; missing_input for a file; unavailable for a part
/// that this build lacks.
Result<MeshedBody> mesh_body(const shots::Body& body, shots::Axis up);

} // namespace wry::pipeline
