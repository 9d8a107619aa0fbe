#include "sim/scene/collider.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/geometry/primitives.h"

namespace wry::scene {

namespace {

void place(geometry::SurfaceMesh& mesh, const Mat3& rotation, const Vec3& translation) {
  mesh.vertices = ((mesh.vertices * rotation.transpose()).rowwise() + translation.transpose()).eval();
}

void append(geometry::SurfaceMesh& mesh, const geometry::SurfaceMesh& more) {
  const Eigen::Index vertices = mesh.vertices.rows(), triangles = mesh.triangles.rows();
  mesh.vertices.conservativeResize(vertices + more.vertices.rows(), 3);
  mesh.vertices.bottomRows(more.vertices.rows()) = more.vertices;
  mesh.triangles.conservativeResize(triangles + more.triangles.rows(), 3);
  mesh.triangles.bottomRows(more.triangles.rows()) = more.triangles.array() + static_cast<std::int32_t>(vertices);
}

Result<geometry::SurfaceMesh> box_surface(const Vec3& centre, const Mat3& axes, const Vec3& size) {
  Result<geometry::SurfaceMesh> mesh = geometry::make_block_surface(geometry::box_block(size), size.maxCoeff());
  if (mesh)
    place(*mesh, axes, centre);
  return mesh;
}

Result<geometry::SurfaceMesh> surface_of(const PlaneObstacle&, double) {
  return make_error(ErrorCode::bad_input, "a plane has no end, so it has no surface of triangles");
}

Result<geometry::SurfaceMesh> surface_of(const BoxObstacle& box, double) {
  geometry::SurfaceMesh all;
  all.vertices.resize(0, 3);
  all.triangles.resize(0, 3);
  for (const BoxPart& part : box_parts(box)) {
    Result<geometry::SurfaceMesh> mesh = box_surface(box.centre + box.axes * part.centre, box.axes, part.size);
    if (!mesh)
      return mesh;
    append(all, *mesh);
  }
  return all;
}

Result<geometry::SurfaceMesh> surface_of(const SphereObstacle& sphere, double edge) {
  Result<geometry::SurfaceMesh> mesh = geometry::make_sphere(sphere.radius, edge);
  if (mesh)
    place(*mesh, Mat3::Identity(), sphere.centre);
  return mesh;
}

Result<geometry::SurfaceMesh> surface_of(const CylinderObstacle& cylinder, double edge) {
  const Vec3 axis = cylinder.to - cylinder.from;
  Result<geometry::SurfaceMesh> mesh =
      geometry::make_block_surface(geometry::cylinder_block(cylinder.radius, axis.norm(), geometry::Axis::y), edge);
  if (mesh)
    place(*mesh, Eigen::Quaterniond::FromTwoVectors(Vec3::UnitY(), axis).toRotationMatrix(),
          0.5 * (cylinder.from + cylinder.to));
  return mesh;
}

Result<geometry::SurfaceMesh> surface_of(const MeshObstacle& mesh, double) {
  return *mesh.mesh;
}

ObstacleBounds bounds_of(const PlaneObstacle&) {
  const Vec3 far = Vec3::Constant(std::numeric_limits<double>::infinity());
  return {-far, far};
}

ObstacleBounds bounds_of(const BoxObstacle& box) {
  const Vec3 reach = box.axes.cwiseAbs() * (0.5 * box.size);
  return {box.centre - reach, box.centre + reach};
}

ObstacleBounds bounds_of(const SphereObstacle& sphere) {
  const Vec3 reach = Vec3::Constant(sphere.radius);
  return {sphere.centre - reach, sphere.centre + reach};
}

ObstacleBounds bounds_of(const CylinderObstacle& cylinder) {
  const Vec3 axis = (cylinder.to - cylinder.from).normalized();
  const Vec3 reach = cylinder.radius * (Vec3::Ones() - axis.cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
  return {cylinder.from.cwiseMin(cylinder.to) - reach, cylinder.from.cwiseMax(cylinder.to) + reach};
}

ObstacleBounds bounds_of(const MeshObstacle& mesh) {
  const Vec3 half = Vec3::Constant(0.5 * mesh.thickness);
  ObstacleBounds bounds{mesh.mesh->vertices.colwise().minCoeff().transpose() - half,
                        mesh.mesh->vertices.colwise().maxCoeff().transpose() + half};
  for (std::size_t i = 0; mesh.sequence && i < mesh.sequence->samples.size(); ++i) {
    const Points& sample = mesh.sequence->samples[i];
    bounds.low = bounds.low.cwiseMin(sample.colwise().minCoeff().transpose() - half);
    bounds.high = bounds.high.cwiseMax(sample.colwise().maxCoeff().transpose() + half);
  }
  return bounds;
}

} // namespace

const MeshSequence* Collider::sequence() const {
  const auto* mesh = std::get_if<MeshObstacle>(&shape);
  return mesh != nullptr ? mesh->sequence.get() : nullptr;
}

bool BoxObstacle::is_container() const {
  return std::find(open.begin(), open.end(), true) != open.end();
}

std::vector<BoxPart> box_parts(const BoxObstacle& box, double least_wall) {
  if (!box.is_container())
    return {{Vec3::Zero(), box.size}};
  std::vector<BoxPart> parts;
  Vec3 low = -0.5 * box.size, high = 0.5 * box.size; // what the walls so far leave
  const double outward = std::max(0.0, least_wall - box.wall);
  for (int axis = 0; axis < 3; ++axis) {
    double inner_low = low[axis], inner_high = high[axis];
    for (const int side : {0, 1}) {
      const int face = 2 * axis + side;
      if (box.open[static_cast<std::size_t>(face)])
        continue;
      Vec3 part_low = low, part_high = high;
      if (side == 0) {
        inner_low = low[axis] + box.wall;
        part_high[axis] = inner_low;
        part_low[axis] -= outward;
      } else {
        inner_high = high[axis] - box.wall;
        part_low[axis] = inner_high;
        part_high[axis] += outward;
      }
      parts.push_back({0.5 * (part_low + part_high), part_high - part_low});
    }
    low[axis] = inner_low;
    high[axis] = inner_high;
  }
  return parts;
}

Result<geometry::SurfaceMesh> obstacle_surface(const ObstacleShape& shape, double edge) {
  return std::visit([&](const auto& one) { return surface_of(one, edge); }, shape);
}

ObstacleBounds obstacle_bounds(const ObstacleShape& shape) {
  return std::visit([](const auto& one) { return bounds_of(one); }, shape);
}

} // namespace wry::scene
