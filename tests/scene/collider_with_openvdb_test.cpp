#include <cmath>
#include <memory>
#include <random>

#include <gtest/gtest.h>

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

} // namespace
} // namespace wry::scene
