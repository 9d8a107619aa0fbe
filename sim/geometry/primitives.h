#pragma once

#include <array>

#include "sim/base/result.h"
#include "sim/geometry/axis.h"
#include "sim/geometry/surface_mesh.h"

namespace wry::geometry {

/// The cross-section of a block, across its axis.
enum class Section {
  box,
  round, ///< an ellipse inscribed in the two sizes across the axis
};

/// A box, rod, cylinder, sheet or disc, centred at the origin: whatever is an extruded rectangle or ellipse.
struct Block {
  Vec3 size = Vec3::Ones();       ///< extents along x, y, z [m]
  Section section = Section::box; ///< across `axis`
  Axis axis = Axis::z;            ///< of extrusion: a rod's length, a sheet's normal
  Axis u_axis = Axis::x;          ///< the body coordinate u runs 0..1 along it
  Axis v_axis = Axis::y;          ///< the body coordinate v runs 0..1 along it
};

/// A box of that size [m]; u along x, v along y.
Block box_block(const Vec3& size);

/// A rod along `axis`: `height` lies along the next axis, `width` along the one after that (rods along x: height y,
/// width z); u runs along the length, v along the width [m]. A round section takes `width` and `height` as diameters.
Block rod_block(double length, double width, double height, Section section, Axis axis = Axis::x);

/// A cylinder that stands along `axis`; u along it.
Block cylinder_block(double radius, double height, Axis axis = Axis::y);

/// A sheet across `normal`: `depth` and v lie along the next axis, `width` and u along the one after that (normal y:
/// width x, depth z) [m].
Block sheet_block(double width, double depth, double thickness, Axis normal = Axis::y);

/// Numbers of cells along x, y, z so that no cell is longer than `target_edge` [m], at least one each. Round sections
/// get the same even number both ways across. Errors: bad_input unless sizes and edge are positive and the count is
/// sane.
Result<std::array<int, 3>> cells_for_edge(const Block& block, double target_edge);

/// The closed, outward surface of a block with edges of about `target_edge` [m]. Vertices of round sections lie on the
/// ellipse. Errors: bad_input as for cells_for_edge.
Result<SurfaceMesh> make_block_surface(const Block& block, double target_edge);

/// A geodesic sphere around the origin, all vertices on it.
Result<SurfaceMesh> make_sphere(double radius, double target_edge);

/// A torus around the origin: a circle of `major_radius` in the plane across `axis`, thickened by `minor_radius` [m].
Result<SurfaceMesh> make_torus(double major_radius, double minor_radius, Axis axis, double target_edge);

/// The point of the block at lattice coordinates s in [0, 1]^3; squares go to discs by concentric squares -> circles,
/// so that rings of cells stay rings (Shirley & Chiu 1997).
Vec3 block_point(const Block& block, const Vec3& s);

} // namespace wry::geometry
