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

/// Of a collider that deforms there is where its vertices are, and how fast they go.
void add_vertices(const scene::Collider& collider, const scene::MeshSequence& sequence, double time, FrameBody& body) {
  const scene::Pose pose = collider.motion.pose(time);
  const auto add = [&](const char* name, const Points& values) {
    Channel channel;
    channel.name = name;
    channel.components = 3;
    channel.on = ChannelOn::vertex;
    channel.values.assign(values.data(), values.data() + values.size());
    body.channels.push_back(std::move(channel));
  };
  Points positions = sequence.at(time) * pose.rotation.transpose();
  positions.rowwise() += pose.translation.transpose();
  Points velocities = sequence.velocities_at(time) * pose.rotation.transpose();
  if (collider.motion.moves()) {
    const scene::Twist twist = collider.motion.twist(time);
    for (Eigen::Index i = 0; i < velocities.rows(); ++i)
      velocities.row(i) += twist.at(positions.row(i)).transpose();
  }
  add("position", positions);
  add("velocity", velocities);
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
    if (const scene::MeshSequence* sequence = collider->sequence())
      add_vertices(*collider, *sequence, frame.time, body);
    frame.bodies.push_back(std::move(body));
  }
}

} // namespace wry::pipeline
