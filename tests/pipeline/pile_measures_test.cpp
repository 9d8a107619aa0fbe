#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "pipeline/measure/measure.h"

namespace wry::pipeline {
namespace {

using Kind = shots::MeasureKind;

constexpr double SPACING = 0.02;

/// A heap of this slope, 1 m high, up along z, on points of a lattice; it began as a box of 1 x 2 x 3 m.
struct Heap {
  MeasurePlan plan;
  SceneStatic scene;
  Frame frame;

  explicit Heap(double degrees) {
    const double slope = std::tan(degrees * std::numbers::pi / 180.0);
    const double radius = 1.0 / slope;
    Channel positions{"position", ChannelOn::particle, 3, ChannelStorage::float64, {}};
    for (double x = -radius; x <= radius; x += SPACING) {
      for (double y = -radius; y <= radius; y += SPACING) {
        for (double z = 0.0; z <= 1.0 - slope * std::hypot(x, y); z += SPACING)
          positions.values.insert(positions.values.end(), {x, y, z});
      }
    }
    Channel velocities = positions;
    velocities.name = "velocity";
    for (double& value : velocities.values)
      value = 2.0;
    scene.bodies.resize(1);
    frame.bodies.resize(1);
    frame.bodies[0].channels = {positions, velocities};
    plan.up = plan.direction = Vec3::UnitZ();
    plan.density = 1000.0;
    plan.particle_mass = 1000.0 * SPACING * SPACING * SPACING;
    plan.start_low = Vec3(-0.5, -1, 0);
    plan.start_high = Vec3(0.5, 1, 3);
  }
  double measure(Kind kind) {
    plan.kind = kind;
    return evaluate_measure(plan, scene, frame);
  }
};

TEST(PileMeasures, SlopeOfAConeIsItsAngle) {
  for (const double degrees : {25.0, 35.0, 60.0})
    EXPECT_NEAR(Heap(degrees).measure(Kind::repose_angle), degrees, 1.5);
}

TEST(PileMeasures, HeightIsAboveTheFootOfTheStart) {
  Heap heap(45.0);
  heap.plan.start_low.z() = -0.5;
  EXPECT_NEAR(heap.measure(Kind::pile_height), 1.5, SPACING);
}

TEST(PileMeasures, RunOutIsOverTheHalfWidthOfTheStart) {
  Heap heap(45.0);
  heap.plan.direction = Vec3::UnitX();
  const double quantile = heap.measure(Kind::front_position);
  EXPECT_GT(quantile, 0.5);
  EXPECT_LT(quantile, 1.0);
  // |x| has 98 % below what x has 99 % below.
  const double along_x = heap.measure(Kind::run_out);
  EXPECT_GT(along_x, quantile / 0.5 - 1.0);
  EXPECT_LT(along_x, 1.0 / 0.5 - 1.0);
  heap.plan.direction = Vec3::UnitY();
  EXPECT_NEAR(heap.measure(Kind::run_out), (along_x + 1.0) / 2.0 - 1.0, 0.02);
}

TEST(PileMeasures, KineticEnergyIsThatOfTheParticles) {
  Heap heap(45.0);
  const double count = static_cast<double>(heap.frame.bodies[0].channels[0].values.size() / 3);
  EXPECT_NEAR(heap.measure(Kind::kinetic_energy), 0.5 * heap.plan.particle_mass * count * 12.0, 1e-9 * count);
}

TEST(PileMeasures, FractionOutsideLooksAtWhereTheyAreNow) {
  Heap heap(45.0);
  heap.plan.region = scene::BoxRegion{Vec3(0.0101, -9, -9), Vec3(9, 9, 9)};
  EXPECT_NEAR(heap.measure(Kind::fraction_outside), 0.5, 0.02);
  heap.plan.region = scene::BoxRegion{Vec3(5, 5, 5), Vec3(9, 9, 9)};
  EXPECT_EQ(heap.measure(Kind::fraction_outside), 1.0);
}

} // namespace
} // namespace wry::pipeline
