#include "sim/scene/collider_field.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "sim/geometry/closest_point_tree.h"

namespace wry::scene {
namespace {

ColliderField field_of(ObstacleShape shape, const ColliderFieldSettings& settings = {}) {
  auto collider = std::make_shared<Collider>();
  collider->name = "thing";
  collider->shape = std::move(shape);
  Result<ColliderField> field = ColliderField::create(std::move(collider), settings);
  EXPECT_TRUE(field) << (field ? "" : field.error().message);
  return *field;
}

BoxObstacle turned_box() {
  BoxObstacle box;
  box.centre = Vec3(0.2, -0.1, 0.4);
  box.axes = Eigen::AngleAxisd(0.6, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  box.size = Vec3(1.0, 0.6, 0.4);
  return box;
}

CylinderObstacle slanted_cylinder() {
  return {Vec3(-0.4, 0.1, 0.0), Vec3(0.5, 0.4, -0.3), 0.25};
}

/// The distance along the normal back to the surface is the distance: what every exact signed distance keeps.
void expect_points_lead_to_surface(const ColliderField& field, double tolerance) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-1.2, 1.2);
  for (int i = 0; i < 400; ++i) {
    const Vec3 point(place(random), place(random), place(random));
    const ColliderSample sample = field.sample({}, point);
    EXPECT_NEAR(sample.normal.norm(), 1.0, 1e-12);
    if (sample.distance > 1e-3) {
      EXPECT_NEAR(field.sample({}, point - sample.distance * sample.normal).distance, 0.0, tolerance);
    }
  }
}

TEST(Collider, DistancesOutsideAreExactForEveryAnalyticShape) {
  expect_points_lead_to_surface(field_of(turned_box()), 1e-12);
  expect_points_lead_to_surface(field_of(SphereObstacle{Vec3(0.1, 0.2, 0.3), 0.5}), 1e-12);
  expect_points_lead_to_surface(field_of(slanted_cylinder()), 1e-12);
  expect_points_lead_to_surface(field_of(PlaneObstacle{Vec3(0, 0.1, 0), Vec3(0.6, 0.8, 0)}), 1e-12);
}

TEST(Collider, SurfacesAgreeWithDistances) {
  const ObstacleShape shapes[] = {turned_box(), SphereObstacle{Vec3(0.1, 0.2, 0.3), 0.5}, slanted_cylinder()};
  for (const ObstacleShape& shape : shapes) {
    const Result<geometry::SurfaceMesh> surface = obstacle_surface(shape, 0.02);
    ASSERT_TRUE(surface) << surface.error().message;
    const ColliderField field = field_of(shape);
    const ObstacleBounds bounds = obstacle_bounds(shape);
    for (Eigen::Index v = 0; v < surface->vertices.rows(); ++v) {
      const Vec3 vertex = surface->vertices.row(v);
      EXPECT_NEAR(field.sample({}, vertex).distance, 0.0, 1e-9);
      EXPECT_GE((vertex - bounds.low).minCoeff(), -1e-9);
      EXPECT_GE((bounds.high - vertex).minCoeff(), -1e-9);
    }
    // Outward: the mesh's own sign agrees on both sides.
    const geometry::ClosestPointTree tree(*surface);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-1.0, 1.0);
    for (int i = 0; i < 200; ++i) {
      const Vec3 point(place(random), place(random), place(random));
      EXPECT_NEAR(tree.signed_distance(point), field.sample({}, point).distance, 2e-3);
    }
  }
}

TEST(Collider, AnOpenBoxIsItsWalls) {
  BoxObstacle bed;
  bed.size = Vec3(0.4, 0.6, 0.2);
  bed.open = {false, false, false, true, false, true};
  bed.wall = 0.01;
  const ColliderField field = field_of(bed);
  EXPECT_NEAR(field.sample({}, Vec3(0, 0, 0)).distance, 0.1 - 0.01, 1e-12); // the floor is nearest, 9 cm below
  EXPECT_LT(field.sample({}, Vec3(0.195, 0, 0)).distance, 0.0);
  EXPECT_GT(field.sample({}, Vec3(0, 0.299, 0)).distance, 0.05); // the open back
  EXPECT_NEAR(field.sample({}, Vec3(0.18, 0, 0)).distance, 0.01, 1e-12);
  EXPECT_LT((field.sample({}, Vec3(0.18, 0, 0)).normal - Vec3(-1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((field.sample({}, Vec3(0.21, 0, 0)).normal - Vec3(1, 0, 0)).norm(), 1e-12);
}

TEST(Collider, ThinWallsGrowOutward) {
  BoxObstacle bed;
  bed.size = Vec3(0.4, 0.6, 0.2);
  bed.open[5] = true;
  bed.wall = 0.01;
  ColliderFieldSettings settings;
  settings.least_wall = 0.05;
  const ColliderField field = field_of(bed, settings);
  EXPECT_NEAR(field.sample({}, Vec3(0.18, 0, 0.05)).distance, 0.01, 1e-12); // the inner face stays
  EXPECT_NEAR(field.sample({}, Vec3(0.25, 0, 0.05)).distance, 0.01, 1e-12); // the outer one is 4 cm further out
}

TEST(Collider, WallsTouchButDoNotOverlap) {
  BoxObstacle box;
  box.size = Vec3(0.4, 0.6, 0.2);
  box.open[5] = true;
  box.wall = 0.02;
  double volume = 0;
  for (const BoxPart& part : box_parts(box))
    volume += part.size.prod();
  EXPECT_NEAR(volume, 0.4 * 0.6 * 0.2 - 0.36 * 0.56 * 0.18, 1e-15);
}

TEST(Collider, AnOpenMeshIsASheetWithTwoSides) {
  auto mesh = std::make_shared<geometry::SurfaceMesh>();
  mesh->vertices.resize(4, 3);
  mesh->vertices << -1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1;
  mesh->triangles.resize(2, 3);
  mesh->triangles << 0, 1, 2, 0, 2, 3;
  const ColliderField field = field_of(MeshObstacle{mesh, false, 0.1});
  for (const double y : {-0.3, 0.3}) {
    const ColliderSample sample = field.sample({}, Vec3(0.2, y, 0.1));
    EXPECT_NEAR(sample.distance, 0.25, 1e-12);
    EXPECT_LT((sample.normal - Vec3(0, y > 0 ? 1 : -1, 0)).norm(), 1e-12);
  }
  EXPECT_LT(field.sample({}, Vec3(0, 0, 0)).distance, 0.0);
}

TEST(Collider, MovesWithItsPose) {
  const ColliderField field = field_of(turned_box());
  Pose pose;
  pose.rotation = Eigen::AngleAxisd(1.1, Vec3::UnitZ()).toRotationMatrix();
  pose.translation = Vec3(0.5, 0.1, -0.3);
  const Vec3 point(0.9, 0.8, 0.7);
  const ColliderSample rest = field.sample({}, point);
  const ColliderSample moved = field.sample(pose, pose.apply(point));
  EXPECT_NEAR(rest.distance, moved.distance, 1e-14);
  EXPECT_LT((pose.rotation * rest.normal - moved.normal).norm(), 1e-14);
}

TEST(Collider, PlanesHaveNoSurface) {
  EXPECT_FALSE(obstacle_surface(PlaneObstacle{}, 0.1));
}

} // namespace
} // namespace wry::scene
