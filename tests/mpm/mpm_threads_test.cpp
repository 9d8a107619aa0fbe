#include <gtest/gtest.h>

#include "tests/mpm/mpm_support.h"

namespace wry::mpm {
namespace {

/// Sand and an elastic ball that fall together on a sticky floor and a sphere, over a few sorts.
MpmPlan busy_plan(Precision precision) {
  MpmPlan plan = column_plan(column_material(), precision);
  plan.bodies[0].initial_velocity = Vec3(0.8, -0.3, 0.0);
  Material elastic;
  elastic.name = "elastic";
  elastic.youngs_modulus = {2e4, 2e4, 1e4};
  elastic.plastic_scale = {1, 1, 1};
  plan.bodies.push_back(box_of_matter(Vec3(0.06, -0.04, 0.05), Vec3(0.13, 0.03, 0.1), 0.0125, 8, elastic));
  plan.bodies[1].name = "block";
  plan.bodies[1].initial_velocity = Vec3(-1, 0, 0);
  auto ball = std::make_shared<scene::Collider>();
  ball->name = "ball";
  ball->shape = scene::SphereObstacle{Vec3(0.1, 0, 0), 0.04};
  plan.colliders.push_back(ball);
  return plan;
}

/// Every bit of the state.
bool same(const StateArchive& a, const StateArchive& b) {
  if (a.size() != b.size())
    return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].name != b[i].name || a[i].values != b[i].values)
      return false;
  }
  return true;
}

class Repeatable : public ::testing::TestWithParam<Precision> {};
INSTANTIATE_TEST_SUITE_P(Both, Repeatable, ::testing::Values(Precision::f32, Precision::f64));

TEST_P(Repeatable, AnyNumberOfThreadsGivesTheSameBits) {
  std::vector<StateArchive> ends;
  for (const int threads : {1, 2, 3, 8}) {
    const std::unique_ptr<MpmSimulation> simulation = make(busy_plan(GetParam()), threads);
    run_to(*simulation, 0.05);
    ends.push_back(simulation->archive());
  }
  for (const StateArchive& end : ends)
    EXPECT_TRUE(same(end, ends.front()));
}

TEST_P(Repeatable, WhatGoesOnFromACheckpointHasTheSameBits) {
  const std::unique_ptr<MpmSimulation> straight = make(busy_plan(GetParam()));
  const std::unique_ptr<MpmSimulation> resumed = make(busy_plan(GetParam()));
  bool sorted_after = false;
  for (int step = 0; step < 40; ++step)
    ASSERT_TRUE(straight->step(1.0).ok());
  const StateArchive middle = straight->archive();
  for (int step = 0; step < 40; ++step) {
    const Result<StepStats> stats = straight->step(1.0);
    ASSERT_TRUE(stats.ok());
    sorted_after = sorted_after || stats->sorted;
  }
  ASSERT_TRUE(resumed->restore(middle).ok());
  for (int step = 0; step < 40; ++step)
    ASSERT_TRUE(resumed->step(1.0).ok());
  EXPECT_TRUE(sorted_after);
  EXPECT_TRUE(same(straight->archive(), resumed->archive()));
}

TEST(Checkpoint, OfAnotherShotIsRefusedByName) {
  const std::unique_ptr<MpmSimulation> one = make(busy_plan(Precision::f64));
  MpmPlan other = column_plan(column_material(), Precision::f64);
  const std::unique_ptr<MpmSimulation> smaller = make(std::move(other));
  const Status status = smaller->restore(one->archive());
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::io);
  EXPECT_NE(status.error().message.find("mpm/stiffness_factor"), std::string::npos);
}

} // namespace
} // namespace wry::mpm
