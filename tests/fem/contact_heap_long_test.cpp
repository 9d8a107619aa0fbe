#include <cmath>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "sim/geometry/structured_tets.h"
#include "tests/fem/contact_scene_support.h"

namespace wry::fem {
namespace {

using namespace test;

TEST(ContactHeap, EightBoxesThrownTogetherComeToRestWithoutIntersecting) {
  FemPlan plan;
  for (int i = 0; i < 8; ++i) {
    const Vec3 place(0.2 * (i % 2), 0.05 + 0.2 * (i / 4), 0.2 * ((i / 2) % 2)); // their diagonals are 0.17
    FemBody body = box_body(fmt::format("box{}", i), Vec3(-0.05, -0.05, -0.05), Vec3(0.1, 0.1, 0.1), {2, 2, 2}, 2e5);
    std::shared_ptr<geometry::TetMesh> mesh = std::make_shared<geometry::TetMesh>(*body.mesh);
    const Mat3 turn =
        Eigen::AngleAxisd(0.7 * i, Vec3(std::sin(1.0 + i), std::cos(2.0 * i), 0.3).normalized()).toRotationMatrix();
    mesh->vertices = ((mesh->vertices * turn.transpose()).rowwise() + (place + Vec3(0, 0.1, 0)).transpose()).eval();
    body.mesh = mesh;
    body.initial_velocity = Vec3(i % 2 == 0 ? 1.5 : -1.5, -1.0, i % 4 < 2 ? 1.0 : -1.0);
    plan.bodies.push_back(body);
  }
  plan.planes.push_back({"ground", Vec3::Zero(), Vec3::UnitY(), 0.5});
  plan.contact = ContactOptions{true, true, {0.4, 0.4}, {}};
  plan.settings.newton_tolerance = 1e-5;
  const Result<std::unique_ptr<FemSimulation>> made = FemSimulation::create(plan, 1, native_isa());
  ASSERT_TRUE(made) << made.error().message;
  int contacts = 0;
  while ((*made)->time() < 2.0) {
    const Result<StepStats> stats = (*made)->step(2.0);
    ASSERT_TRUE(stats) << stats.error().message;
    contacts = std::max(contacts, stats->contacts);
    ASSERT_EQ(find_intersection(plan, **made), "") << (*made)->time();
  }
  EXPECT_GT(contacts, 8);
  for (int i = 0; i < 8; ++i)
    EXPECT_LT(velocity_of(plan, **made, i).norm(), 0.05) << i;
}

/// A mat of 240 cells of 12 tets, held at both ends, which turn against each other by ten turns: its outermost matter
/// is then four times as long as it was, and every part of it lies on another.
void wind_up(double seconds, const std::string& name) {
  constexpr double DEGREES = 5.0 * 360.0; // of each end
  FemPlan plan;
  plan.gravity.setZero();
  geometry::Block block = geometry::box_block(Vec3(0.5, 0.01, 0.3));
  const Result<geometry::TetMesh> mesh = geometry::make_block_tets(block, {{20, 1, 12}, geometry::CellSplit::twelve});
  ASSERT_TRUE(mesh);
  ASSERT_EQ(mesh->tets.rows(), 2880);
  plan.bodies.push_back(make_body(std::make_shared<geometry::TetMesh>(*mesh), ElasticModel::neo_hookean, 2e4, 0.4));
  for (const double side : {-1.0, 1.0}) {
    DrivenNodes drive;
    drive.name = side < 0.0 ? "left" : "right";
    drive.nodes = vertices_at(*mesh, 0, 0.25 * side);
    drive.motion = *scene::Motion::along_keys(
        {{{0.0, Vec3::Zero(), Vec3::UnitX(), 0.0}, {seconds, Vec3::Zero(), Vec3::UnitX(), -side * DEGREES}},
         Vec3(0.25 * side, 0, 0)});
    plan.driven.push_back(drive);
  }
  plan.contact = ContactOptions{};
  plan.settings.max_time_step = 0.04;
  plan.settings.newton_tolerance = 1e-6;
  const Outcome outcome = run_and_check(plan, seconds, name);
  EXPECT_EQ(outcome.intersection, "");
  EXPECT_GT(outcome.contacts, 100);
  EXPECT_EQ(outcome.error, "");
  EXPECT_NEAR(outcome.reached, seconds, 1e-9);
}

TEST(TwistedMat, WindsUpForAHundredSecondsWithoutIntersecting) {
  wind_up(100.0, "a mat of 2,880 tets twisted by ten turns in 100 s");
}

TEST(TwistedMat, WindsUpFourTimesAsFast) {
  wind_up(25.0, "a mat of 2,880 tets twisted by ten turns in 25 s");
}

} // namespace
} // namespace wry::fem
