#include "pipeline/run/collider_frames.h"

#include <variant>

#include "sim/scene/collider.h"

namespace wry::pipeline {

namespace {

/// Round shapes are drawn with this many edges across.
constexpr double EDGES_ACROSS = 40.0;

bool has_surface(const scene::Collider& collider) {
  return !std::holds_alternative<scene::PlaneObstacle>(collider.shape);
}

} // namespace

Status add_colliders(const SimPlan& plan, SceneStatic& scene) {
  for (const auto& collider : plan.colliders) {
    if (!has_surface(*collider))
      continue;
    const scene::ObstacleBounds bounds = scene::obstacle_bounds(collider->shape);
    Result<geometry::SurfaceMesh> surface =
        scene::obstacle_surface(collider->shape, (bounds.high - bounds.low).maxCoeff() / EDGES_ACROSS);
    if (!surface)
      return make_error(surface.error().code, "collider {}: {}", collider->name, surface.error().message);
    SceneBody body;
    body.name = collider->name;
    body.look = collider->look;
    body.simulated = false;
    body.rest_positions = std::move(surface->vertices);
    body.triangles = std::move(surface->triangles);
    scene.bodies.push_back(std::move(body));
  }
  return {};
}

void add_collider_poses(const SimPlan& plan, Frame& frame) {
  for (const auto& collider : plan.colliders) {
    if (!has_surface(*collider))
      continue;
    const scene::Pose pose = collider->motion.pose(frame.time);
    FrameBody body;
    body.name = collider->name;
    body.transform.topLeftCorner<3, 3>() = pose.rotation;
    body.transform.topRightCorner<3, 1>() = pose.translation;
    frame.bodies.push_back(std::move(body));
  }
}

} // namespace wry::pipeline
