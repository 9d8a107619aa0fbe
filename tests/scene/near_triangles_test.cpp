#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sim/base/parallel.h"
#include "sim/geometry/primitives.h"
#include "sim/scene/collider_field.h"
#include "sim/scene/distance_bounds.h"
#include "sim/scene/near_triangles.h"

namespace wry::scene {
namespace {

std::vector<Vec3> points_around(int count) {
  std::mt19937 random(19);
  std::uniform_real_distribution<double> place(-1.1, 1.1);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i)
    points.emplace_back(place(random), 0.5 * place(random), place(random));
  return points;
}

geometry::SurfaceMesh torus() {
  return *geometry::make_torus(0.6, 0.25, geometry::Axis::y, 0.1);
}
const Cubes CUBES(Vec3(-0.95, -0.35, -0.95), Vec3(0.95, 0.35, 0.95), 0.06);

TEST(Cubes, EveryPointOfTheBoxIsInACubeOfItsOwnNumber) {
  const Cubes cubes(Vec3(-1, 0, 2), Vec3(1, 0.7, 3.1), 0.1);
  std::vector<Vec3> centre_of(static_cast<std::size_t>(cubes.count()), Vec3::Constant(1e9));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  for (int i = 0; i < 20000; ++i) {
    const Vec3 point(-1 + 2 * share(random), 0.7 * share(random), 2 + 1.1 * share(random));
    const Cubes::Place place = cubes.find(point);
    ASSERT_GE(place.cube, 0);
    ASSERT_LT(place.cube, cubes.count());
    EXPECT_LE((point - place.centre).cwiseAbs().maxCoeff(), 0.5 * cubes.side() * (1.0 + 1e-9));
    EXPECT_LE((point - place.centre).norm(), cubes.radius());
    Vec3& centre = centre_of[static_cast<std::size_t>(place.cube)];
    if (centre.x() > 1e8)
      centre = place.centre;
    EXPECT_EQ(centre, place.centre);
  }
  EXPECT_EQ(cubes.find(Vec3(-1.01, 0.3, 2.5)).cube, -1);
  EXPECT_EQ(cubes.find(Vec3(0, 0.3, 3.2)).cube, -1);
  EXPECT_EQ(cubes.find(Vec3::Constant(std::nan(""))).cube, -1);
}

TEST(Cubes, AreNeverSoManyThatMemoryRunsOut) {
  const Cubes cubes(Vec3::Zero(), Vec3(100, 100, 100), 1e-3);
  EXPECT_LT(cubes.count(), 6'000'000);
  EXPECT_GT(cubes.side(), 0.5);
}

TEST(NearTriangles, GiveTheAnswersOfTheTreeToTheLastBit) {
  const geometry::ClosestPointTree tree(torus());
  const NearTriangles near(tree, CUBES);
  const std::vector<Vec3> points = points_around(20000);
  const Threads threads(2);
  threads.for_each(points.size(), 64, [&](std::size_t i) {
    const geometry::ClosestPoint expected = tree.closest(points[i]), found = near.closest(points[i]);
    EXPECT_EQ(found.triangle, expected.triangle);
    EXPECT_EQ(found.point, expected.point);
    EXPECT_EQ(found.barycentric, expected.barycentric);
    EXPECT_EQ(found.distance, expected.distance);
  });
}

TEST(DistanceBounds, HoldTheDistanceBetweenThem) {
  const geometry::ClosestPointTree tree(torus());
  int asked = 0;
  const DistanceBounds bounds(CUBES, 1.0, [&](const Vec3& point) {
    ++asked;
    return tree.signed_distance(point);
  });
  int outside = 0;
  const std::vector<Vec3> points = points_around(20000);
  for (const Vec3& point : points) {
    const double distance = tree.signed_distance(point);
    const auto [least, greatest] = bounds.around(point);
    EXPECT_LE(least, distance);
    EXPECT_GE(greatest, distance);
    outside += least < -10.0 ? 1 : 0;
    if (least > -10.0) {
      EXPECT_LE(greatest - least, 2.01 * CUBES.radius());
    }
  }
  EXPECT_GT(outside, 100);
  EXPECT_LT(outside, 10000);
  EXPECT_LT(asked, CUBES.count());
}

TEST(Collider, AnExactMeshAnswersTheSameWithWhatItKeepsAsWithout) {
  auto collider = std::make_shared<Collider>();
  collider->shape = MeshObstacle{std::make_shared<geometry::SurfaceMesh>(torus()), true, 0.0};
  ColliderFieldSettings settings;
  settings.closed_mesh = MeshDistance::exact;
  const ColliderField plain = *ColliderField::create(collider, settings);
  settings.voxel = 0.06;
  const ColliderField kept = *ColliderField::create(collider, settings);
  Pose pose;
  pose.translation = Vec3(0.1, -0.05, 0.2);
  double loosest = 0.0;
  for (const Vec3& point : points_around(20000)) {
    const ColliderSample expected = plain.sample(pose, point), found = kept.sample(pose, point);
    EXPECT_EQ(found.distance, expected.distance);
    EXPECT_EQ(found.normal, expected.normal);
    for (const double reach : {-0.1, 0.0, 0.02, 0.15}) {
      const double least = kept.least_distance(pose, point, reach);
      if (least >= reach) {
        EXPECT_GE(expected.distance, reach);
      } else {
        EXPECT_LE(least, expected.distance + 1e-12);
        loosest = std::max(loosest, std::min(expected.distance, reach) - least);
      }
    }
  }
  EXPECT_LT(loosest, 0.11);
}

} // namespace
} // namespace wry::scene
