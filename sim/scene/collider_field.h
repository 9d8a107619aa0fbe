#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "sim/base/result.h"
#include "sim/scene/collider.h"

namespace wry::scene {

/// What a point sees of a collider.
struct ColliderSample {
  double distance = 0.0;        ///< [m], negative inside the matter of the collider
  Vec3 normal = Vec3::UnitY();  ///< unit, away from the collider's matter, in the world
  Vec3 velocity = Vec3::Zero(); ///< of its surface, beside that of its motion as a whole: of what deforms [m/s]
};

/// How far it is to a closed mesh.
enum class MeshDistance {
  sampled, ///< by a level set: cheap, edges are rounded by a fraction of a voxel
  exact,   ///< to the triangles
};

/// How finely meshes are sampled.
struct ColliderFieldSettings {
  double voxel = 0.0;       ///< of a closed mesh's level set, and of what is kept to answer cheaply [m]; usual: half a
                            ///< grid cell
  double least_wall = 0.0;  ///< walls of open boxes and open meshes count as at least this thick [m]
  double least_solid = 0.0; ///< what is thinner in a closed mesh counts as this thick, growing on both sides [m]
  MeshDistance closed_mesh = MeshDistance::sampled;
};

/// Signed distance to a collider at any time, for methods that test points: exact for planes, boxes, spheres and
/// cylinders, an OpenVDB level set for closed meshes (bounded to the mesh's box: far outside it is a lower bound of the
/// distance), exact two-sided distance minus half the thickness for open ones. Meshes that deform are always exact, and
/// stand where deform_to() put them last, at first where they are at time 0. Cheap to copy; queries may run on many
/// threads.
class ColliderField {
public:
  /// Errors: those of the level set: bad_input, out_of_memory, unavailable without OpenVDB.
  static Result<ColliderField> create(std::shared_ptr<const Collider> collider, const ColliderFieldSettings& settings);

  const Collider& collider() const { return *m_collider; }
  /// Puts the vertices of a mesh that deforms where they are at a time [s]; of others, nothing changes.
  void deform_to(double time);
  /// At a point of the world where the collider is in this pose.
  ColliderSample sample(const Pose& pose, const Vec3& point) const;

  /// The distance alone [m]: of a closed mesh a seventh of the cost, since a normal takes six samples more. From
  /// `reach` on it may be any lower bound that is not below `reach`: cheap where only what is near matters.
  double distance(const Pose& pose, const Vec3& point, double reach = std::numeric_limits<double>::infinity()) const;

  /// A cheap lower bound of the distance [m], seldom by more than a voxel too low; from `reach` on any that is not
  /// below `reach`.
  double least_distance(const Pose& pose, const Vec3& point, double reach) const;

  /// The shape alone, made ready for queries; of the implementation.
  struct Shape;

private:
  ColliderField() = default;
  std::shared_ptr<const Collider> m_collider;
  std::shared_ptr<const Shape> m_shape;
  double m_half_wall = 0.0; ///< of an open mesh [m]
};

} // namespace wry::scene
