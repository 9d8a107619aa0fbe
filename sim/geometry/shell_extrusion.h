#pragma once

#include <string_view>
#include <vector>

#include "sim/base/result.h"
#include "sim/geometry/surface_mesh.h"
#include "sim/geometry/tet_mesh.h"
#include "sim/geometry/tet_quality.h"

namespace wry::geometry {

/// What to do where a body is too thin to be hollowed to the wall that is asked for (a tip, a rim, a thin plate).
enum class ThinPlaces {
  thinner_wall, ///< make the wall thinner there, and report every such place
  refuse,       ///< error naming the worst place
};

/// How a closed surface becomes a hollow shell.
struct ShellSettings {
  double thickness = 0; ///< of the wall, inward from the surface [m]
  int layers = 2;       ///< tets across the wall, at least 1; fewer than 2 bend too stiffly
  double edge = 0;      ///< target edge on the surface [m]
  double finest = 0.5;  ///< edges may shrink to this share of the target where the surface bends tightly
  ThinPlaces thin_places = ThinPlaces::thinner_wall;
  TetLimits limits{5.0, 165.0, .02};
};

/// A place where the wall is thinner than asked.
struct ThinPlace {
  Vec3 point = Vec3::Zero(); ///< on the surface [m]
  double depth = 0;          ///< the largest distance from the surface that the body has there [m]
  double thickness = 0;      ///< the least wall that was made [m]
  int columns = 0;           ///< surface vertices that belong to the place
};

/// Which way of making the shell was taken.
enum class ShellMethod { extruded, extruded_with_thinner_walls };

/// "extruded" or "extruded with locally thinner walls", for `wry plan`.
std::string_view shell_method_name(ShellMethod method);

/// A hollow shell and how well it was made.
struct ShellMesh {
  TetMesh mesh; ///< vertex i of layer l is row l * columns + i; layer 0 is the outer surface
  int columns = 0;
  Triangles outer_triangles; ///< of the outer surface, in rows of layer 0
  TetQuality quality;
  ShellMethod method = ShellMethod::extruded;
  std::int64_t self_intersections = 0; ///< pairs of boundary triangles that cut each other; 0 in what is returned
  Vec3 self_intersection_point = Vec3::Zero(); ///< the first of them [m]
  int refinements = 0;                         ///< times that tight bends were divided more finely until the gate held
  double reference_volume = 0;                 ///< of the wall between the surface and its offset [m^3]
  double volume_error = 0;                     ///< relative
  double min_wall = 0;                         ///< least and greatest distance of an inner vertex from the surface [m]
  double max_wall = 0;
  double mean_outer_edge = 0;         ///< [m]
  std::vector<ThinPlace> thin_places; ///< worst first
};

/// Remeshes a closed surface to the target edge, extrudes it inward to `thickness` by the signed distance, and splits
/// the layers of prisms into tets. Vertices slide along their level sets until the angles hold. Errors: bad_input for
/// an open or non-manifold surface, settings that are not positive, places too thin (as `thin_places` says), or a mesh
/// that does not keep the limits, each with the place.
Result<ShellMesh> extrude_shell(const SurfaceMesh& surface, const ShellSettings& settings);

} // namespace wry::geometry
