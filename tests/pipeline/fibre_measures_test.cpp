#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/measure/fibre_measures.h"
#include "sim/base/rotation.h"

namespace wry::pipeline {
namespace {

FrameBody with_channel(const char* name, int components, std::vector<double> values) {
  FrameBody body;
  body.channels.push_back({name, ChannelOn::particle, components, ChannelStorage::float64, std::move(values)});
  return body;
}

MeasurePlan along(const Vec3& direction) {
  MeasurePlan plan;
  plan.direction = direction;
  plan.cell = 0.1;
  return plan;
}

TEST(FibreMeasures, AlignmentIsTheSquareOfTheCosineWithTheFibre) {
  const Vec4 q = quaternion_exponential(0.5 * Vec3::UnitX()); // turns z towards -y by .5 rad
  const FrameBody body = with_channel("orientation", 4, {1, 0, 0, 0, q[0], q[1], q[2], q[3]});
  const double c = std::cos(0.5), s = std::sin(0.5);
  EXPECT_NEAR(mean_alignment(along(Vec3::UnitZ()), {}, body), (1.0 + c * c) / 2.0, 1e-12);
  EXPECT_NEAR(mean_alignment(along(Vec3::UnitY()), {}, body), s * s / 2.0, 1e-12);
  // Two directions at an angle of .5: eigenvalues (1 +- cos .5) / 2.
  EXPECT_NEAR(second_moment(along(Vec3::UnitZ()), {}, body), (1.0 + c) / 2.0, 1e-12);
}

TEST(FibreMeasures, SecondMomentsOfGrainsCountBeforeTheirFrames) {
  FrameBody body = with_channel("orientation", 4, {1, 0, 0, 0});
  body.channels.push_back(
      {"second_moment", ChannelOn::particle, 6, ChannelStorage::float32, {0.5, 0.3, 0.2, 0.0, 0.0, 0.1}});
  EXPECT_NEAR(mean_alignment(along(Vec3::UnitX()), {}, body), 0.5, 1e-12);
  EXPECT_NEAR(second_moment(along(Vec3::UnitX()), {}, body), 0.4 + std::sqrt(0.01 + 0.01), 1e-12);
}

TEST(FibreMeasures, AlignmentWithTheFlowIsThatOfWhatMoves) {
  // Fibres along z: one goes along it, one across, one at 60 degrees to it, one stands still.
  FrameBody body = with_channel("orientation", 4, {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  const double s = std::sqrt(0.75);
  body.channels.push_back(
      {"velocity", ChannelOn::particle, 3, ChannelStorage::float32, {0, 0, -3, 2, 0, 0, s, 0, 0.5, 0, 0, 0}});
  EXPECT_NEAR(mean_alignment(along(Vec3::Zero()), {}, body), (1.0 + 0.0 + 0.25) / 3.0, 1e-12);
  body.channels.back().values.assign(12, 0.0);
  EXPECT_TRUE(std::isnan(mean_alignment(along(Vec3::Zero()), {}, body)));
}

TEST(FibreMeasures, WithoutAxesThereIsNoAlignment) {
  const FrameBody body = with_channel("position", 3, {0, 0, 0});
  EXPECT_TRUE(std::isnan(mean_alignment(along(Vec3::UnitX()), {}, body)));
  EXPECT_TRUE(std::isnan(second_moment(along(Vec3::UnitX()), {}, body)));
}

TEST(FibreMeasures, TheLargestPieceIsWhatHangsTogether) {
  // Three in a row of cells, one beyond a gap of a cell, one touching it by a corner.
  const FrameBody body = with_channel("position", 3,
                                      {0.05, 0.05, 0.05, 0.15, 0.05, 0.05, 0.25, 0.05, 0.05, //
                                       0.45, 0.05, 0.05, 0.55, 0.15, 0.15});
  EXPECT_NEAR(largest_fragment(along(Vec3::UnitX()), {}, body), 0.6, 1e-12);
  const FrameBody whole = with_channel("position", 3, {-0.05, 0.0, 0.0, 0.05, 0.0, 0.0});
  EXPECT_EQ(largest_fragment(along(Vec3::UnitX()), {}, whole), 1.0);
}

} // namespace
} // namespace wry::pipeline
