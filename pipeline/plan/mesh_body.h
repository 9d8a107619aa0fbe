#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/plan/scene_plan.h"
#include "render/mesh_appearance.h"
#include "shots/shot.h"
#include "sim/base/result.h"
#include "sim/geometry/surface_mesh.h"
#include "sim/geometry/tet_mesh.h"
#include "sim/scene/transform.h"

namespace wry::pipeline {

/// A body ready for the solver: placed, meshed, checked.
struct MeshedBody {
  std::shared_ptr<const geometry::TetMesh> mesh; ///< of a plate: vertices without tets
  Triangles triangles;                           ///< of a plate
  double sheet_thickness = 0.0;                  ///< of a plate made from a sheet, else 0 [m]
  BodyReport report;
  std::vector<Asset> assets;
};

/// How a shot places a shape or mesh.
scene::Placement compile_placement(const shots::Placed& placed, shots::Axis up);

/// What fills a body's surface.
enum class Filling { tets, nothing };

/// Makes a body's rest mesh: imports or generates its surface, sizes and places it, fills or hollows it, and holds it
/// against the quality gate. With Filling::nothing the surface itself is kept, for plates. Errors: bad_input with the
/// body's line; missing_input for a file; unavailable for a part that this build lacks.
Result<MeshedBody> mesh_body(const shots::Body& body, shots::Axis up, Filling filling = Filling::tets);

/// The closed surface of a body's shape where the shot places it, outward; curved primitives have edges of about `edge`
/// [m]. Errors: as mesh_body(); bad_input for a tet mesh.
struct PlacedSurface {
  geometry::SurfaceMesh surface;
  std::string description;
  std::vector<Asset> assets;
  std::vector<std::string> notes;
  std::optional<render::MeshAppearance> appearance; ///< of a mesh file with materials
};
Result<PlacedSurface> body_surface(const shots::Body& body, shots::Axis up, double edge);

} // namespace wry::pipeline
