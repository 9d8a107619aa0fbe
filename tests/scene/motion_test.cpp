#include "sim/scene/motion.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace wry::scene {
namespace {

constexpr double PI = std::numbers::pi;

Motion must(const Result<Motion>& motion) {
  EXPECT_TRUE(motion) << (motion ? "" : motion.error().message);
  return motion ? *motion : Motion();
}

/// A bed that tips about a hinge, and then moves off.
MotionKeys tipping(Ease ease) {
  MotionKeys keys;
  keys.pivot = Vec3(0.5, 0.65, 0.2);
  keys.ease = ease;
  keys.keys = {{0.2, Vec3::Zero(), Vec3::UnitX(), 0.0},
               {0.7, Vec3::Zero(), Vec3::UnitX(), 43.0},
               {1.2, Vec3(0, 0, 1.5), Vec3::UnitX(), 43.0}};
  return keys;
}

/// Central difference of where a point of the resting body is.
Vec3 velocity_by_difference(const Motion& motion, double time, const Vec3& rest) {
  const double h = 1e-6;
  return (motion.pose(time + h).apply(rest) - motion.pose(time - h).apply(rest)) / (2.0 * h);
}

TEST(Motion, WithoutKeysStandsStill) {
  const Motion motion;
  EXPECT_FALSE(motion.moves());
  EXPECT_EQ(motion.pose(3.0).apply(Vec3(1, 2, 3)), Vec3(1, 2, 3));
  EXPECT_EQ(motion.twist(3.0).at(Vec3(1, 2, 3)), Vec3::Zero());
}

TEST(Motion, TurnsAboutThePivotAndLeavesItInPlace) {
  const MotionKeys keys = tipping(Ease::linear);
  const Motion motion = must(Motion::along_keys(keys));
  EXPECT_TRUE(motion.moves());
  for (const double time : {0.0, 0.2, 0.31, 0.5, 0.7})
    EXPECT_LT((motion.pose(time).apply(keys.pivot) - keys.pivot).norm(), 1e-14) << time;
  // A point one metre from the hinge along -y goes down by sin of the angle... and 43 degrees are half done at .45 s.
  const Vec3 end = motion.pose(0.45).apply(keys.pivot + Vec3(0, -1, 0)) - keys.pivot;
  const double angle = 21.5 * PI / 180.0;
  EXPECT_LT((end - Vec3(0, -std::cos(angle), -std::sin(angle))).norm(), 1e-14);
}

TEST(Motion, StandsStillBeforeTheFirstAndAfterTheLastKey) {
  const Motion motion = must(Motion::along_keys(tipping(Ease::linear)));
  EXPECT_EQ(motion.twist(0.1).angular, Vec3::Zero());
  EXPECT_EQ(motion.twist(1.3).linear, Vec3::Zero());
  EXPECT_LT((motion.pose(5.0).apply(Vec3(0.5, 0.65, 0.2)) - Vec3(0.5, 0.65, 1.7)).norm(), 1e-14);
}

TEST(Motion, TwistIsTheDerivativeOfThePose) {
  MotionKeys keys = tipping(Ease::smooth);
  keys.keys.push_back({2.0, Vec3(1, 0, 1.5), Vec3(1, 1, 0), 200.0}); // another axis: the shortest way
  for (const Ease ease : {Ease::linear, Ease::smooth}) {
    keys.ease = ease;
    const Motion motion = must(Motion::along_keys(keys));
    for (const double time : {0.25, 0.4, 0.69, 0.9, 1.1, 1.4, 1.95}) {
      const Vec3 rest(0.3, -0.2, 0.7);
      const Vec3 expected = velocity_by_difference(motion, time, rest);
      const Vec3 actual = motion.twist(time).at(motion.pose(time).apply(rest));
      EXPECT_LT((expected - actual).norm(), 1e-8) << time;
    }
  }
}

TEST(Motion, SmoothKeysStartAndEndAtRest) {
  const Motion motion = must(Motion::along_keys(tipping(Ease::smooth)));
  EXPECT_LT(motion.twist(0.2).angular.norm(), 1e-12);
  EXPECT_LT(motion.twist(0.7 - 1e-9).angular.norm(), 1e-6);
  EXPECT_NEAR(motion.twist(0.45).angular.x(), 1.5 * 43.0 * PI / 180.0 / 0.5, 1e-12);
}

TEST(Motion, KeysOfOneAxisMayTurnManyTimes) {
  MotionKeys keys;
  keys.keys = {{0, Vec3::Zero(), Vec3::UnitZ(), 0}, {10, Vec3::Zero(), Vec3::UnitZ(), 3600}};
  const Motion motion = must(Motion::along_keys(keys));
  EXPECT_NEAR(motion.twist(4.0).angular.z(), 2.0 * PI, 1e-12);
  EXPECT_LT((motion.pose(1.25).apply(Vec3(1, 0, 0)) - Vec3(0, 1, 0)).norm(), 1e-12);
}

TEST(Motion, OneKeyIsAPlaceToStand) {
  MotionKeys keys;
  keys.keys = {{1.0, Vec3(1, 0, 0), Vec3::UnitZ(), 90.0}};
  const Motion motion = must(Motion::along_keys(keys));
  EXPECT_FALSE(motion.moves());
  EXPECT_LT((motion.pose(0.0).apply(Vec3(1, 0, 0)) - Vec3(1, 1, 0)).norm(), 1e-15);
}

TEST(Motion, ThroughSamplesPassesThroughThem) {
  const Motion keyed = must(Motion::along_keys(tipping(Ease::smooth)));
  std::vector<PoseSample> samples;
  for (int i = 0; i <= 24; ++i)
    samples.push_back({0.1 * i, keyed.pose(0.1 * i)});
  const Motion motion = must(Motion::through_samples(samples));
  for (const PoseSample& sample : samples) {
    EXPECT_LT((motion.pose(sample.time).rotation - sample.pose.rotation).norm(), 1e-12);
    EXPECT_LT((motion.pose(sample.time).translation - sample.pose.translation).norm(), 1e-12);
  }
  const Vec3 rest(0.3, -0.2, 0.7);
  EXPECT_LT((velocity_by_difference(motion, 0.55, rest) - motion.twist(0.55).at(motion.pose(0.55).apply(rest))).norm(),
            1e-8);
}

TEST(Motion, RefusesKeysThatMakeNoSense) {
  MotionKeys keys = tipping(Ease::linear);
  keys.keys[1].time = 0.2;
  EXPECT_NE(Motion::along_keys(keys).error().message.find("key 2"), std::string::npos);
  keys = tipping(Ease::linear);
  keys.keys[2].axis = Vec3::Zero();
  EXPECT_NE(Motion::along_keys(keys).error().message.find("key 3"), std::string::npos);
  keys = tipping(Ease::linear);
  keys.keys[0].translation.x() = std::nan("");
  EXPECT_NE(Motion::along_keys(keys).error().message.find("key 1"), std::string::npos);
  Pose mirrored;
  mirrored.rotation(0, 0) = -1;
  EXPECT_FALSE(Motion::through_samples({{0.0, Pose()}, {1.0, mirrored}}));
}

} // namespace
} // namespace wry::scene
