#pragma once

#include <array>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "sim/base/result.h"
#include "sim/base/types.h"
#include "sim/geometry/surface_mesh.h"
#include "sim/scene/mesh_sequence.h"
#include "sim/scene/motion.h"

namespace wry::scene {

/// An unbounded half-space that bodies stay above.
struct PlaneCollider {
  std::string name;
  Vec3 point = Vec3::Zero();   ///< a point on the plane [m]
  Vec3 normal = Vec3::UnitY(); ///< unit, towards the free side
  double friction = 0.0;       ///< Coulomb coefficient
};

// Shapes of colliders, in the world where they rest [m].
struct PlaneObstacle {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitY(); ///< unit, towards the free side
};
/// A solid box, or a container: with open sides it is only its walls, which stand inside `size`.
struct BoxObstacle {
  Vec3 centre = Vec3::Zero();
  Mat3 axes = Mat3::Identity();  ///< columns: the box's own x, y, z
  Vec3 size = Vec3::Ones();      ///< along its own axes
  std::array<bool, 6> open = {}; ///< -x, +x, -y, +y, -z, +z
  double wall = 0.0;             ///< thickness of the walls when a side is open

  bool is_container() const;
};
/// A solid box in a box's own frame.
struct BoxPart {
  Vec3 centre = Vec3::Zero(), size = Vec3::Ones(); ///< [m]
};
/// The box itself, or the walls of a container: they touch, but do not overlap. Walls thinner than `least_wall` [m]
/// grow outward, so that what stands in the container stays where it is.
std::vector<BoxPart> box_parts(const BoxObstacle& box, double least_wall = 0.0);

struct SphereObstacle {
  Vec3 centre = Vec3::Zero();
  double radius = 1.0;
};
/// With flat ends.
struct CylinderObstacle {
  Vec3 from = Vec3::Zero(), to = Vec3::UnitY(); ///< middles of the ends
  double radius = 1.0;
};
/// An artist's mesh: solid when it is closed, else a sheet with two sides.
struct MeshObstacle {
  std::shared_ptr<const geometry::SurfaceMesh> mesh; ///< outward when closed
  bool closed = true;
  double thickness = 0.0; ///< of an open sheet; grid methods cannot feel less than a cell
  std::shared_ptr<const MeshSequence> sequence = nullptr; ///< where its vertices are over time; null: as in `mesh`
};
using ObstacleShape = std::variant<PlaneObstacle, BoxObstacle, SphereObstacle, CylinderObstacle, MeshObstacle>;

/// What matter that touches a collider may do.
enum class ColliderContact {
  separate, ///< leave, and slide with friction
  slip,     ///< slide with friction, but not leave
  sticky,   ///< neither
};

/// An obstacle, the same for every method. Solids of the finite element method know `separate` only.
struct Collider {
  std::string name;
  ObstacleShape shape;
  double friction = 0.5; ///< Coulomb coefficient
  ColliderContact contact = ColliderContact::separate;
  Motion motion;
  std::string look;  ///< of its pictures; empty: the default
  bool shown = true; ///< drawn; planes are drawn as the ground only

  /// Of a mesh that deforms, else null.
  const MeshSequence* sequence() const;
  bool moves() const { return motion.moves() || sequence() != nullptr; }
};

/// The surface of a shape where it rests, outward, with edges of about `edge` [m] where it is curved; walls of an open
/// box are a solid each. Errors: bad_input for planes, which have no end.
Result<geometry::SurfaceMesh> obstacle_surface(const ObstacleShape& shape, double edge);

/// The least box around the shape where it rests, of a mesh that deforms at all times; planes: infinite.
struct ObstacleBounds {
  Vec3 low, high; ///< [m]
};
ObstacleBounds obstacle_bounds(const ObstacleShape& shape);

} // namespace wry::scene
