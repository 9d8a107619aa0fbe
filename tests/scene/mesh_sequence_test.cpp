#include "sim/scene/mesh_sequence.h"

#include <gtest/gtest.h>

#include "sim/geometry/primitives.h"
#include "sim/scene/collider_field.h"

namespace wry::scene {
namespace {

Points at_x(double x) {
  Points points(2, 3);
  points << x, 1, 2, x, 4, 5;
  return points;
}

TEST(MeshSequence, GoesStraightBetweenSamplesAndStandsStillOutside) {
  MeshSequence sequence;
  sequence.samples = {at_x(0.0), at_x(1.0), at_x(4.0)};
  sequence.first_time = 0.5;
  sequence.interval = 0.25;
  const auto x = [&](double time) { return sequence.at(time)(1, 0); };
  EXPECT_EQ(x(-1.0), 0.0);
  EXPECT_EQ(x(0.5), 0.0);
  EXPECT_DOUBLE_EQ(x(0.625), 0.5);
  EXPECT_DOUBLE_EQ(x(0.75), 1.0);
  EXPECT_DOUBLE_EQ(x(0.9), 1.0 + 3.0 * 0.6);
  EXPECT_EQ(x(1.0), 4.0);
  EXPECT_EQ(x(99.0), 4.0);
  const auto speed = [&](double time) { return sequence.velocities_at(time)(0, 0); };
  EXPECT_EQ(speed(0.4), 0.0);
  EXPECT_DOUBLE_EQ(speed(0.6), 4.0);
  EXPECT_DOUBLE_EQ(speed(0.75), 12.0);
  EXPECT_EQ(speed(1.0), 0.0);
  sequence.samples.resize(1);
  EXPECT_EQ(x(0.6), 0.0);
  EXPECT_EQ(speed(0.6), 0.0);
}

/// A ball whose radius grows from 0.5 by one per second, in a collider that also moves as a whole.
ColliderField growing_ball(bool closed) {
  Result<geometry::SurfaceMesh> ball = geometry::make_sphere(0.5, 0.05);
  EXPECT_TRUE(ball.ok());
  auto sequence = std::make_shared<MeshSequence>();
  sequence->samples = {ball->vertices, 3.0 * ball->vertices};
  auto collider = std::make_shared<Collider>();
  collider->name = "ball";
  collider->shape = MeshObstacle{std::make_shared<geometry::SurfaceMesh>(*ball), closed, 0.1, sequence};
  Result<ColliderField> field = ColliderField::create(collider, {});
  EXPECT_TRUE(field.ok());
  return *field;
}

TEST(DeformingField, IsWhereTheMeshIsAndKnowsHowFastItsSurfaceGoes) {
  constexpr double FACETS = 2e-3; // how far a facet is inside the ball, at most
  for (const bool closed : {true, false}) {
    ColliderField field = growing_ball(closed);
    const double half = closed ? 0.0 : 0.05;
    const Vec3 direction = Vec3(1, 2, 2) / 3.0;
    Pose pose;
    pose.rotation = Eigen::AngleAxisd(0.7, Vec3::UnitZ()).toRotationMatrix();
    pose.translation = Vec3(3, 0, 0);
    for (const double time : {0.0, 0.25}) {
      field.deform_to(time);
      const double radius = 0.5 + time;
      const Vec3 point = pose.apply(1.2 * direction);
      const ColliderSample sample = field.sample(pose, point);
      EXPECT_NEAR(sample.distance, 1.2 - radius - half, FACETS) << closed << time;
      EXPECT_NEAR(field.distance(pose, point), sample.distance, 1e-12);
      EXPECT_NEAR((sample.normal - pose.rotation * direction).norm(), 0.0, 0.1);
      EXPECT_NEAR((sample.velocity - pose.rotation * direction).norm(), 0.0, 0.1) << "one metre per second outward";
    }
    const double inside = field.sample(pose, pose.apply(0.2 * direction)).distance;
    EXPECT_NEAR(inside, closed ? -0.55 : 0.55 - half, FACETS) << "a sheet has no inside";
  }
}

} // namespace
} // namespace wry::scene
