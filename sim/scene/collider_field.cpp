#include "sim/scene/collider_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/geometry/closest_point_tree.h"
#include "sim/geometry/signed_distance.h"
#include "sim/scene/distance_bounds.h"
#include "sim/scene/near_triangles.h"

namespace wry::scene {

namespace {

ColliderSample sample_box(const BoxPart& box, const Vec3& point) {
  const Vec3 from_centre = point - box.centre;
  const Vec3 beyond = from_centre.cwiseAbs() - 0.5 * box.size;
  const auto sign = [&](int axis) { return from_centre[axis] < 0.0 ? -1.0 : 1.0; };
  ColliderSample sample;
  int nearest = 0;
  const double inside = beyond.maxCoeff(&nearest);
  if (inside <= 0.0) {
    sample.distance = inside;
    sample.normal = sign(nearest) * Vec3::Unit(nearest);
    return sample;
  }
  const Vec3 outside = beyond.cwiseMax(0.0);
  sample.distance = outside.norm();
  for (int axis = 0; axis < 3; ++axis)
    sample.normal[axis] = sign(axis) * outside[axis] / sample.distance;
  return sample;
}

/// A distance to the round side and one to the flat ends, both negative inside, with their normals.
ColliderSample join_side_and_end(double side, const Vec3& side_normal, double end, const Vec3& end_normal) {
  if (side > 0.0 && end > 0.0) {
    const double distance = std::hypot(side, end);
    return {distance, (side * side_normal + end * end_normal) / distance};
  }
  return side > end ? ColliderSample{side, side_normal} : ColliderSample{end, end_normal};
}

Vec3 any_normal_to(const Vec3& direction) {
  return direction.unitOrthogonal();
}

} // namespace

/// A shape ready for queries in the frame where it rests.
struct ColliderField::Shape {
  virtual ~Shape() = default;
  virtual ColliderSample sample(const Vec3& point) const = 0;
  virtual double distance(const Vec3& point, double /*reach*/) const { return sample(point).distance; }
  virtual double least_distance(const Vec3& point, double reach) const { return distance(point, reach); }
};

namespace {

template <class Function> struct Analytic final : ColliderField::Shape {
  explicit Analytic(Function function_)
      : function(std::move(function_)) {}
  ColliderSample sample(const Vec3& point) const override { return function(point); }
  Function function;
};

template <class Function> std::shared_ptr<const ColliderField::Shape> analytic(Function function) {
  return std::make_shared<Analytic<Function>>(std::move(function));
}

using MadeShape = Result<std::shared_ptr<const ColliderField::Shape>>;

MadeShape make_shape(const PlaneObstacle& plane, const ColliderFieldSettings&) {
  return analytic([plane](const Vec3& point) {
    return ColliderSample{plane.normal.dot(point - plane.point), plane.normal};
  });
}

MadeShape make_shape(const BoxObstacle& box, const ColliderFieldSettings& settings) {
  return analytic([box, parts = box_parts(box, settings.least_wall)](const Vec3& point) {
    const Vec3 local = box.axes.transpose() * (point - box.centre);
    ColliderSample nearest;
    nearest.distance = std::numeric_limits<double>::infinity();
    for (const BoxPart& part : parts) {
      const ColliderSample sample = sample_box(part, local);
      if (sample.distance < nearest.distance)
        nearest = sample;
    }
    nearest.normal = box.axes * nearest.normal;
    return nearest;
  });
}

MadeShape make_shape(const SphereObstacle& sphere, const ColliderFieldSettings&) {
  return analytic([sphere](const Vec3& point) {
    const Vec3 from_centre = point - sphere.centre;
    const double radius = from_centre.norm();
    return ColliderSample{radius - sphere.radius, radius > 0.0 ? Vec3(from_centre / radius) : Vec3(Vec3::UnitY())};
  });
}

MadeShape make_shape(const CylinderObstacle& cylinder, const ColliderFieldSettings&) {
  const Vec3 axis = (cylinder.to - cylinder.from).normalized();
  const double half = 0.5 * (cylinder.to - cylinder.from).norm();
  const Vec3 middle = 0.5 * (cylinder.from + cylinder.to);
  return analytic([axis, half, middle, radius = cylinder.radius](const Vec3& point) {
    const double along = axis.dot(point - middle);
    const Vec3 across = point - middle - along * axis;
    const double away = across.norm();
    const Vec3 side_normal = away > 0.0 ? Vec3(across / away) : any_normal_to(axis);
    return join_side_and_end(away - radius, side_normal, std::abs(along) - half, along < 0.0 ? Vec3(-axis) : axis);
  });
}

/// Where a mesh's cheap bounds of its distance are known: a little beyond what a grid's nodes and particles may touch.
constexpr double BOUNDS_AROUND = 8.0; // cubes
Cubes cubes_around(const geometry::SurfaceMesh& mesh, double side, double margin) {
  const Vec3 around = Vec3::Constant(margin * side);
  return {mesh.vertices.colwise().minCoeff().transpose() - around,
          mesh.vertices.colwise().maxCoeff().transpose() + around, side};
}
std::unique_ptr<const DistanceBounds> bounds_around(const geometry::SurfaceMesh& mesh, double cube, double slope,
                                                    DistanceBounds::Distance distance) {
  return std::make_unique<const DistanceBounds>(cubes_around(mesh, cube, BOUNDS_AROUND), slope, std::move(distance));
}

/// The inside of a closed mesh.
struct Solid final : ColliderField::Shape {
  explicit Solid(geometry::SignedDistance field_)
      : field(std::move(field_)) {}
  double distance(const Vec3& point, double /*reach*/) const override { return distance(point); }
  double distance(const Vec3& point) const {
    const double outside = (point - point.cwiseMax(field.low()).cwiseMin(field.high())).norm();
    return outside > 0.0 ? std::max(field.value(point), outside) : field.value(point);
  }
  ColliderSample sample(const Vec3& point) const override {
    const Vec3 nearest = point.cwiseMax(field.low()).cwiseMin(field.high());
    const double outside = (point - nearest).norm();
    ColliderSample sample;
    sample.distance = distance(point);
    const Vec3 slope = field.gradient(point);
    const double steepness = slope.norm();
    if (steepness > 1e-3)
      sample.normal = slope / steepness;
    else if (outside > 0.0)
      sample.normal = (point - nearest) / outside;
    return sample;
  }
  geometry::SignedDistance field;
};

/// The faces of a closed mesh behind which there is less matter than a grid can feel, and by how much each must grow.
struct ThinFaces {
  geometry::SurfaceMesh mesh;
  std::vector<double> growth; ///< per triangle [m]
};

/// Matter behind a face at a point: how far it is to the face that looks the other way; infinite when that is `least`
/// or more, or when there is none, as at the edge of something thick.
double thickness_behind(const geometry::ClosestPointTree& tree, const Vec3& point, const Vec3& normal, double least) {
  const geometry::ClosestPoint other = tree.closest(point - 0.5 * least * normal);
  const double depth = (point - other.point).dot(normal);
  const bool looks_away = tree.pseudonormal(other).dot(normal) < -0.5;
  return looks_away && depth < least * (1.0 - 1e-6) ? std::max(depth, 0.0) : std::numeric_limits<double>::infinity();
}

ThinFaces thin_faces(const geometry::SurfaceMesh& mesh, double least) {
  constexpr double INNER = 0.8, OUTER = 0.1; // sampled at the middle and near each corner
  const geometry::ClosestPointTree tree(mesh);
  ThinFaces thin;
  thin.mesh.vertices = mesh.vertices;
  std::vector<Eigen::Index> picked;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    Vec3 corner[3];
    for (int k = 0; k < 3; ++k)
      corner[k] = mesh.vertices.row(mesh.triangles(t, k));
    const Vec3 cross = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    if (!(cross.norm() > 0.0))
      continue;
    const Vec3 normal = cross.normalized(), middle = (corner[0] + corner[1] + corner[2]) / 3.0;
    double thinnest = thickness_behind(tree, middle, normal, least);
    for (const Vec3& near : corner) {
      const Vec3 sample = INNER * near + OUTER * (corner[0] + corner[1] + corner[2] - near);
      thinnest = std::min(thinnest, thickness_behind(tree, sample, normal, least));
    }
    if (!std::isfinite(thinnest))
      continue;
    picked.push_back(t);
    thin.growth.push_back(0.5 * (least - thinnest));
  }
  thin.mesh.triangles.resize(static_cast<Eigen::Index>(picked.size()), 3);
  for (std::size_t i = 0; i < picked.size(); ++i)
    thin.mesh.triangles.row(static_cast<Eigen::Index>(i)) = mesh.triangles.row(picked[i]);
  return thin;
}

/// A closed mesh of which some is too thin to be felt: a level set for what is not, and the thin faces as sheets.
struct PartlyThin final : ColliderField::Shape {
  PartlyThin(std::shared_ptr<const ColliderField::Shape> solid_, const geometry::SurfaceMesh& whole,
             const ThinFaces& thin, const ColliderFieldSettings& settings)
      : solid(std::move(solid_))
      , tree(thin.mesh)
      , growth(thin.growth)
      , most_growth(*std::max_element(growth.begin(), growth.end()))
      , least(settings.least_solid)
      , seen(BOUNDS_AROUND * settings.voxel)
      // What is sampled changes along each axis by no more than the distance does, so by sqrt(3) as much along a
      // diagonal.
      , bounds(bounds_around(whole, settings.voxel, std::sqrt(3.0),
                             [this](const Vec3& centre) { return lower_bound(centre); })) {}
  double distance(const Vec3& point, double reach) const override {
    if (std::isfinite(reach)) {
      if (const double bound = bounds->around(point).least; bound >= reach)
        return bound;
    }
    const double to_solid = distance_to_solid(point);
    // No face is nearer than the surface that it is part of: away from it, a lower bound of the distance is enough.
    if (to_solid > 2.0 * least && solid)
      return to_solid - 0.5 * least;
    const double wanted = std::min(to_solid, reach);
    const geometry::ClosestPoint closest = tree.closest_within(point, wanted + most_growth);
    if (closest.triangle < 0)
      return wanted;
    return std::min(to_solid, closest.distance - growth[static_cast<std::size_t>(closest.triangle)]);
  }
  ColliderSample sample(const Vec3& point) const override {
    const double to_solid = distance_to_solid(point);
    const geometry::ClosestPoint closest = tree.closest_within(point, to_solid + most_growth);
    const double distance = closest.triangle < 0
                                ? std::numeric_limits<double>::infinity()
                                : closest.distance - growth[static_cast<std::size_t>(closest.triangle)];
    if (distance >= to_solid)
      return solid->sample(point);
    const Vec3 away = point - closest.point;
    return {distance, closest.distance > 1e-12 ? Vec3(away / closest.distance) : tree.pseudonormal(closest)};
  }
  double lower_bound(const Vec3& centre) const {
    const geometry::ClosestPoint closest = tree.closest_within(centre, seen + most_growth);
    return std::min(distance_to_solid(centre), closest.triangle < 0 ? seen : closest.distance - most_growth);
  }
  double distance_to_solid(const Vec3& point) const {
    return solid ? solid->distance(point, std::numeric_limits<double>::infinity())
                 : std::numeric_limits<double>::infinity();
  }
  std::shared_ptr<const ColliderField::Shape> solid; ///< null: nothing that a voxel sees
  geometry::ClosestPointTree tree;
  std::vector<double> growth;
  double most_growth; ///< no face reaches further [m]
  double least;
  double seen; ///< what is further counts as this far [m]
  std::unique_ptr<const DistanceBounds> bounds;
};

/// The inside of a closed mesh, by its triangles. With `cube`, what is kept for cubes of space answers most questions.
struct ExactSolid final : ColliderField::Shape {
  ExactSolid(const geometry::SurfaceMesh& mesh, double cube)
      : tree(mesh)
      , low(mesh.vertices.colwise().minCoeff().transpose())
      , high(mesh.vertices.colwise().maxCoeff().transpose()) {
    if (!(cube > 0.0))
      return;
    const Cubes cubes = cubes_around(mesh, cube, 3.0);
    bounds = std::make_unique<const DistanceBounds>(
        cubes, 1.0, [this](const Vec3& centre) { return tree.signed_distance(centre); });
    near = std::make_unique<const NearTriangles>(tree, cubes);
  }
  double least_distance(const Vec3& point, double reach) const override {
    if (!bounds)
      return distance(point, reach);
    const double outside = (low - point).cwiseMax(point - high).maxCoeff();
    return outside >= reach ? outside : std::max(outside, bounds->around(point).least);
  }
  ColliderSample sample(const Vec3& point) const override {
    const geometry::ClosestPoint closest = near ? near->closest(point) : tree.closest(point);
    const Vec3 outward = tree.pseudonormal(closest);
    const Vec3 away = point - closest.point;
    const double side = away.dot(outward) < 0.0 ? -1.0 : 1.0;
    return {side * closest.distance, closest.distance > 1e-12 ? Vec3(side / closest.distance * away) : outward};
  }
  geometry::ClosestPointTree tree;
  Vec3 low, high; ///< the mesh's box [m]
  std::unique_ptr<const DistanceBounds> bounds;
  std::unique_ptr<const NearTriangles> near; ///< null, as the bounds: queries are few
};

MadeShape make_solid(const MeshObstacle& mesh, const ColliderFieldSettings& settings) {
  if (settings.closed_mesh == MeshDistance::exact)
    return std::shared_ptr<const ColliderField::Shape>(std::make_shared<ExactSolid>(*mesh.mesh, settings.voxel));
  const ThinFaces thin = settings.least_solid > 0.0 ? thin_faces(*mesh.mesh, settings.least_solid) : ThinFaces{};
  Result<geometry::SignedDistance> distance = geometry::SignedDistance::from_surface(*mesh.mesh, settings.voxel);
  const bool all_thin = static_cast<Eigen::Index>(thin.growth.size()) == mesh.mesh->triangles.rows();
  if (!distance && !(all_thin && distance.error().code == ErrorCode::bad_input))
    return std::move(distance).error();
  std::shared_ptr<const ColliderField::Shape> solid;
  if (distance)
    solid = std::make_shared<Solid>(std::move(*distance));
  if (thin.growth.empty())
    return solid;
  return std::shared_ptr<const ColliderField::Shape>(
      std::make_shared<PartlyThin>(std::move(solid), *mesh.mesh, thin, settings));
}

/// An open mesh with half its thickness on both sides.
struct Sheet final : ColliderField::Shape {
  Sheet(const geometry::SurfaceMesh& mesh, double half_, double cube)
      : tree(mesh)
      , half(half_) {
    if (cube > 0.0)
      bounds = bounds_around(mesh, cube, 1.0,
                             [this, cube](const Vec3& centre) { return distance_from(centre, BOUNDS_AROUND * cube); });
  }
  double distance(const Vec3& point, double reach) const override {
    if (bounds && std::isfinite(reach)) {
      if (const double bound = bounds->around(point).least; bound >= reach)
        return bound;
    }
    return distance_from(point, reach);
  }
  double least_distance(const Vec3& point, double reach) const override {
    return bounds ? bounds->around(point).least : distance_from(point, reach);
  }
  double distance_from(const Vec3& point, double reach) const {
    const geometry::ClosestPoint closest = tree.closest_within(point, reach + half);
    return closest.triangle < 0 ? reach : closest.distance - half;
  }
  ColliderSample sample(const Vec3& point) const override {
    const geometry::ClosestPoint closest = tree.closest(point);
    const Vec3 away = point - closest.point;
    return {closest.distance - half,
            closest.distance > 0.0 ? Vec3(away / closest.distance) : tree.pseudonormal(closest)};
  }
  geometry::ClosestPointTree tree;
  double half;
  std::unique_ptr<const DistanceBounds> bounds; ///< null: the exact distance is wanted, and not often
};

double half_wall(const MeshObstacle& mesh, const ColliderFieldSettings& settings) {
  return 0.5 * std::max(mesh.thickness, settings.least_wall);
}

MadeShape make_sheet(const MeshObstacle& mesh, const ColliderFieldSettings& settings) {
  return std::shared_ptr<const ColliderField::Shape>(
      std::make_shared<Sheet>(*mesh.mesh, half_wall(mesh, settings), settings.voxel));
}

/// A mesh at one moment of its deformation: a solid when it is closed, else with half its thickness on both sides.
struct Deformed final : ColliderField::Shape {
  Deformed(const MeshObstacle& mesh, double time, double half_)
      : tree({mesh.sequence->at(time), mesh.mesh->triangles, {}})
      , velocities(mesh.sequence->velocities_at(time))
      , closed(mesh.closed)
      , half(half_) {}
  double distance(const Vec3& point, double reach) const override {
    if (closed)
      return tree.signed_distance(point);
    const geometry::ClosestPoint closest = tree.closest_within(point, reach + half);
    return closest.triangle < 0 ? reach : closest.distance - half;
  }
  ColliderSample sample(const Vec3& point) const override {
    const geometry::ClosestPoint closest = tree.closest(point);
    const Vec3 away = point - closest.point;
    const Vec3 outward = tree.pseudonormal(closest);
    const double side = closed && away.dot(outward) < 0.0 ? -1.0 : 1.0;
    ColliderSample sample;
    sample.distance = side * closest.distance - (closed ? 0.0 : half);
    sample.normal = closest.distance > 1e-12 ? Vec3(side / closest.distance * away) : outward;
    for (int k = 0; k < 3; ++k)
      sample.velocity +=
          closest.barycentric[k] * velocities.row(tree.mesh().triangles(closest.triangle, k)).transpose();
    return sample;
  }
  geometry::ClosestPointTree tree;
  Points velocities;
  bool closed;
  double half;
};

MadeShape make_shape(const MeshObstacle& mesh, const ColliderFieldSettings& settings) {
  if (mesh.sequence)
    return std::shared_ptr<const ColliderField::Shape>(
        std::make_shared<Deformed>(mesh, 0.0, half_wall(mesh, settings)));
  return mesh.closed ? make_solid(mesh, settings) : make_sheet(mesh, settings);
}

} // namespace

Result<ColliderField> ColliderField::create(std::shared_ptr<const Collider> collider,
                                            const ColliderFieldSettings& settings) {
  MadeShape shape = std::visit([&](const auto& one) { return make_shape(one, settings); }, collider->shape);
  if (!shape)
    return make_error(shape.error().code, "collider {}: {}", collider->name, shape.error().message);
  ColliderField field;
  field.m_collider = std::move(collider);
  field.m_shape = std::move(*shape);
  if (const auto* mesh = std::get_if<MeshObstacle>(&field.m_collider->shape))
    field.m_half_wall = half_wall(*mesh, settings);
  return field;
}

void ColliderField::deform_to(double time) {
  if (m_collider->sequence() != nullptr)
    m_shape = std::make_shared<Deformed>(std::get<MeshObstacle>(m_collider->shape), time, m_half_wall);
}

double ColliderField::distance(const Pose& pose, const Vec3& point, double reach) const {
  return m_shape->distance(pose.apply_inverse(point), reach);
}

double ColliderField::least_distance(const Pose& pose, const Vec3& point, double reach) const {
  return m_shape->least_distance(pose.apply_inverse(point), reach);
}

ColliderSample ColliderField::sample(const Pose& pose, const Vec3& point) const {
  ColliderSample sample = m_shape->sample(pose.apply_inverse(point));
  sample.normal = pose.rotation * sample.normal;
  sample.velocity = pose.rotation * sample.velocity;
  return sample;
}

} // namespace wry::scene
