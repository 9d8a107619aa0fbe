#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include "sim/geometry/closest_point_tree.h"
#include "sim/geometry/primitives.h"
#include "sim/scene/collider_field.h"

namespace wry::scene {
namespace {

TEST(Collider, AClosedMeshIsSolidThroughItsLevelSet) {
  const Result<geometry::SurfaceMesh> sphere = geometry::make_sphere(0.5, 0.03);
  ASSERT_TRUE(sphere);
  auto collider = std::make_shared<Collider>();
  collider->shape = MeshObstacle{std::make_shared<geometry::SurfaceMesh>(*sphere), true, 0.0};
  ColliderFieldSettings settings;
  settings.voxel = 0.02;
  const Result<ColliderField> field = ColliderField::create(collider, settings);
  ASSERT_TRUE(field) << field.error().message;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-0.55, 0.55);
  for (int i = 0; i < 300; ++i) {
    const Vec3 point(place(random), place(random), place(random));
    const ColliderSample sample = field->sample({}, point);
    const double expected = point.norm() - 0.5;
    if (std::abs(expected) < 0.05) {
      EXPECT_NEAR(sample.distance, expected, 2e-3);
      EXPECT_GT(sample.normal.dot(point.normalized()), 0.99);
    }
    if (std::abs(expected) > 2e-3) {
      EXPECT_EQ(sample.distance < 0.0, expected < 0.0) << point.transpose();
    }
  }
  // Far away it is a lower bound, but for the facets, that still points away.
  const ColliderSample far = field->sample({}, Vec3(3, 0, 0));
  EXPECT_GT(far.distance, 2.0);
  EXPECT_LE(far.distance, 2.5 + 1e-3);
  EXPECT_GT(far.normal.x(), 0.9);
}

// A slab thinner than a voxel can see, as a truck's bed has them, and an open sheet: both keep cheap lower bounds. They
// count as thicker by `growth` on either side.
void expect_the_same_decisions(const MeshObstacle& mesh, double growth) {
  const geometry::ClosestPointTree tree(*mesh.mesh);
  auto collider = std::make_shared<Collider>();
  collider->shape = mesh;
  ColliderFieldSettings settings;
  settings.voxel = 0.02;
  settings.least_wall = settings.least_solid = 0.05;
  const Result<ColliderField> field = ColliderField::create(collider, settings);
  ASSERT_TRUE(field) << field.error().message;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(-0.8, 0.8), near(-0.1, 0.1);
  int answered_within = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 point(place(random), i % 2 == 0 ? near(random) : place(random), place(random));
    const double exact = field->distance({}, point);
    for (const double reach : {0.0, 0.02, 0.06}) {
      const double answer = field->distance({}, point, reach);
      if (exact < reach) {
        ++answered_within;
        EXPECT_EQ(answer, exact) << point.transpose() << " within " << reach;
      } else {
        EXPECT_GE(answer, reach) << point.transpose();
        // Far away the distance without a reach is a lower bound, too.
        EXPECT_LE(answer, std::max({exact, reach, tree.closest(point).distance - growth})) << point.transpose();
      }
    }
  }
  EXPECT_GT(answered_within, 500);
}

TEST(Collider, AReachChangesNoAnswerWithinItForThinMeshes) {
  const Result<geometry::SurfaceMesh> slab =
      geometry::make_block_surface(geometry::box_block(Vec3(1.0, 0.008, 1.0)), 0.2);
  ASSERT_TRUE(slab);
  expect_the_same_decisions({std::make_shared<geometry::SurfaceMesh>(*slab), true, 0.0}, 0.021);
}

TEST(Collider, AReachChangesNoAnswerWithinItForSheets) {
  geometry::SurfaceMesh sheet;
  sheet.vertices.resize(4, 3);
  sheet.vertices << -0.5, 0, -0.5, 0.5, 0.1, -0.5, 0.5, 0, 0.5, -0.5, 0.1, 0.5;
  sheet.triangles.resize(2, 3);
  sheet.triangles << 0, 2, 1, 0, 3, 2;
  expect_the_same_decisions({std::make_shared<geometry::SurfaceMesh>(sheet), false, 0.01}, 0.025);
}

} // namespace
} // namespace wry::scene
