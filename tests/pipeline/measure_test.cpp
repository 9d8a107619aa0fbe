#include "pipeline/measure/measure.h"

#include <gtest/gtest.h>

namespace wry::pipeline {
namespace {

using Kind = shots::MeasureKind;

/// One tet with legs along the axes, at a corner.
SceneBody rest_tet(double leg) {
  SceneBody body;
  body.name = "tet";
  body.rest_positions.resize(4, 3);
  body.rest_positions << 0, 0, 0, leg, 0, 0, 0, leg, 0, 0, 0, leg;
  body.tets.resize(1, 4);
  body.tets << 0, 1, 2, 3;
  return body;
}

FrameBody moved_tet(const SceneBody& rest, double stretch, const Vec3& offset) {
  FrameBody body;
  body.name = rest.name;
  Channel positions{"position", ChannelOn::vertex, 3, ChannelStorage::float64, {}};
  for (Eigen::Index i = 0; i < 4; ++i) {
    const Vec3 point = stretch * rest.rest_positions.row(i).transpose() + offset;
    positions.values.insert(positions.values.end(), point.data(), point.data() + 3);
  }
  body.channels = {positions,
                   {"velocity", ChannelOn::vertex, 3, ChannelStorage::float32, {0, 0, 0, 3, 4, 0, 1, 0, 0, 0, 0, 2}},
                   {"strain_energy_density", ChannelOn::tet, 1, ChannelStorage::float32, {12.0}}};
  return body;
}

double value_of(const MeasurePlan& plan) {
  const SceneStatic scene{{rest_tet(1.0)}};
  const Frame frame{1, 0.0, {moved_tet(scene.bodies[0], 2.0, Vec3(0, 5, 0))}};
  return measured_value(plan, scene, frame);
}

MeasurePlan plan_of(Kind kind) {
  MeasurePlan plan;
  plan.kind = kind;
  plan.density = 6.0;
  return plan;
}

TEST(Measure, ExtentsFollowTheDirection) {
  EXPECT_DOUBLE_EQ(value_of(plan_of(Kind::height)), 2.0);
  EXPECT_DOUBLE_EQ(value_of(plan_of(Kind::lowest)), 5.0);
  EXPECT_DOUBLE_EQ(value_of(plan_of(Kind::centre)), 5.5);
}

TEST(Measure, OnlyTheChosenNodesCount) {
  MeasurePlan plan = plan_of(Kind::centre);
  plan.nodes = {2};
  EXPECT_DOUBLE_EQ(value_of(plan), 7.0);
}

TEST(Measure, VolumeGrowsWithTheCubeOfTheStretch) {
  EXPECT_DOUBLE_EQ(value_of(plan_of(Kind::volume)), 8.0 / 6.0);
}

TEST(Measure, FastestNodeGivesTheSpeed) {
  EXPECT_DOUBLE_EQ(value_of(plan_of(Kind::speed)), 5.0);
}

TEST(Measure, KineticEnergyTakesAQuarterOfTheRestMassPerNode) {
  // Mass 6 / 6 = 1 kg, a quarter per node; speeds squared 25 + 1 + 4.
  EXPECT_DOUBLE_EQ(value_of(plan_of(Kind::kinetic_energy)), 0.5 * 0.25 * 30.0);
}

TEST(Measure, StrainEnergyIsPerRestVolume) {
  EXPECT_DOUBLE_EQ(value_of(plan_of(Kind::strain_energy)), 2.0);
}

TEST(Measure, RelativeMeasuresAreDividedByTheirReference) {
  MeasurePlan plan = plan_of(Kind::height);
  plan.reference = 4.0;
  EXPECT_DOUBLE_EQ(value_of(plan), 0.5);
}

} // namespace
} // namespace wry::pipeline
