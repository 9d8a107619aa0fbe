#include "sim/scene/collider_field.h"

#include <cmath>
#include <limits>

#include "sim/geometry/closest_point_tree.h"
#include "sim/geometry/signed_distance.h"

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
  virtual double distance(const Vec3& point) const { return sample(point).distance; }
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

/// The inside of a closed mesh.
struct Solid final : ColliderField::Shape {
  explicit Solid(geometry::SignedDistance field_)
      : field(std::move(field_)) {}
  double distance(const Vec3& point) const override {
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

MadeShape make_solid(const MeshObstacle& mesh, const ColliderFieldSettings& settings) {
  Result<geometry::SignedDistance> distance = geometry::SignedDistance::from_surface(*mesh.mesh, settings.voxel);
  if (!distance)
    return std::move(distance).error();
  return std::shared_ptr<const ColliderField::Shape>(std::make_shared<Solid>(std::move(*distance)));
}

MadeShape make_sheet(const MeshObstacle& mesh, const ColliderFieldSettings& settings) {
  const double half = 0.5 * std::max(mesh.thickness, settings.least_wall);
  return analytic([tree = std::make_shared<const geometry::ClosestPointTree>(*mesh.mesh), half](const Vec3& point) {
    const geometry::ClosestPoint closest = tree->closest(point);
    const Vec3 away = point - closest.point;
    return ColliderSample{closest.distance - half,
                          closest.distance > 0.0 ? Vec3(away / closest.distance) : tree->pseudonormal(closest)};
  });
}

MadeShape make_shape(const MeshObstacle& mesh, const ColliderFieldSettings& settings) {
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
  return field;
}

double ColliderField::distance(const Pose& pose, const Vec3& point) const {
  return m_shape->distance(pose.apply_inverse(point));
}

ColliderSample ColliderField::sample(const Pose& pose, const Vec3& point) const {
  ColliderSample sample = m_shape->sample(pose.apply_inverse(point));
  sample.normal = pose.rotation * sample.normal;
  return sample;
}

} // namespace wry::scene
