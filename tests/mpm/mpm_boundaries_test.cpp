#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "sim/mpm/boundaries.h"
#include "tests/mpm/mpm_support.h"

namespace wry::mpm {
namespace {

constexpr double CELL = 0.02;

std::shared_ptr<const scene::Collider> collider(std::string name, scene::ObstacleShape shape, double friction = 0.5,
                                                scene::Motion motion = {}) {
  auto made = std::make_shared<scene::Collider>();
  made->name = std::move(name);
  made->shape = std::move(shape);
  made->friction = friction;
  made->motion = std::move(motion);
  return made;
}

/// Up is z.
MpmPlan loose_sand(const Vec3& low, const Vec3& high, Precision precision = Precision::f32) {
  MpmPlan plan;
  plan.gravity = Vec3(0, 0, -9.81);
  plan.settings.cell = CELL;
  plan.settings.precision = precision;
  plan.bodies.push_back(box_of_matter(low, high, CELL, 8, column_material()));
  return plan;
}

/// A box without a lid, standing on the floor at z = 0; its walls are thinner than a cell.
scene::BoxObstacle open_box() {
  scene::BoxObstacle box;
  box.centre = Vec3(0, 0, 0.1);
  box.size = Vec3(0.3, 0.3, 0.2);
  box.open = {false, false, false, false, false, true};
  box.wall = 0.002;
  return box;
}

double least(const MpmSimulation& simulation, int axis) {
  return channel_of(simulation, 0, "position").col(axis).minCoeff();
}

TEST(ContactVelocity, FollowsTheThreeKinds) {
  const Vec3 n = Vec3::UnitZ();
  const Vec3 wall(0, 0, 0.5);
  const auto at = [&](const Vec3& v, scene::ColliderContact contact) {
    return contact_velocity(v, wall, n, contact, 0.5);
  };
  using C = scene::ColliderContact;
  EXPECT_EQ(at(Vec3(3, 0, 2), C::sticky), wall);
  EXPECT_EQ(at(Vec3(3, 0, 2), C::separate), Vec3(3, 0, 2));
  EXPECT_TRUE(at(Vec3(3, 0, -1.5), C::separate).isApprox(Vec3(2, 0, 0.5))); // 3 - mu 2
  EXPECT_TRUE(at(Vec3(0.5, 0, -1.5), C::separate).isApprox(wall));          // friction stops it
  EXPECT_TRUE(at(Vec3(3, 0, 2.5), C::slip).isApprox(Vec3(2, 0, 0.5)));      // pulled back as hard
  EXPECT_TRUE(at(Vec3(0, 0, -1), C::separate).isApprox(wall));              // nothing along the wall
}

TEST(Walls, OpenBoxOfThinWallsDoesNotLeak) {
  MpmPlan plan = loose_sand(Vec3(-0.14, -0.14, 0.01), Vec3(0.14, 0.14, 0.15));
  plan.colliders.push_back(collider("box", open_box()));
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
  run_to(*simulation, 0.3);
  const Points x = channel_of(*simulation, 0, "position");
  const double slack = 1e-4 * CELL;
  EXPECT_GE(x.col(2).minCoeff(), 0.002 - slack);
  EXPECT_LE(x.leftCols(2).cwiseAbs().maxCoeff(), 0.148 + slack);
  EXPECT_LT(x.col(2).maxCoeff(), 0.2);
}

TEST(Walls, ThatSwingRoundCarryTheLoadWithThem) {
  // The box is tipped to 25 degrees about its edge along x in half a second, and half a second on nothing has left it.
  scene::MotionKeys keys;
  keys.keys = {{0.1, Vec3::Zero(), Vec3::UnitX(), 0}, {0.6, Vec3::Zero(), Vec3::UnitX(), 25}};
  keys.pivot = Vec3(0, 0.15, 0);
  keys.ease = scene::Ease::smooth;
  Result<scene::Motion> motion = scene::Motion::along_keys(keys);
  ASSERT_TRUE(motion.ok());
  MpmPlan plan = loose_sand(Vec3(-0.14, -0.14, 0.01), Vec3(0.14, 0.14, 0.07));
  plan.colliders.push_back(collider("box", open_box(), 0.5, *motion));
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
  run_to(*simulation, 1.0);
  const scene::Pose pose = motion->pose(1.0);
  const Points x = channel_of(*simulation, 0, "position");
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const Vec3 in_box = pose.apply_inverse(x.row(i));
    ASSERT_LE(in_box.head<2>().cwiseAbs().maxCoeff(), 0.148 + 1e-3 * CELL) << i;
    ASSERT_GE(in_box.z(), 0.002 - 1e-3 * CELL) << i;
  }
}

TEST(Walls, ThinSheetKeepsTwoPilesApart) {
  // Sand on one side of a standing sheet without thickness; nothing on the other may feel or meet it.
  auto sheet = std::make_shared<geometry::SurfaceMesh>();
  sheet->vertices.resize(4, 3);
  sheet->vertices << 0, -0.5, -0.1, 0, 0.5, -0.1, 0, 0.5, 0.5, 0, -0.5, 0.5;
  sheet->triangles.resize(2, 3);
  sheet->triangles << 0, 1, 2, 0, 2, 3;
  MpmPlan plan = loose_sand(Vec3(CELL, -0.08, 0), Vec3(0.16, 0.08, 0.2));
  plan.colliders.push_back(collider("floor", scene::PlaneObstacle{Vec3::Zero(), Vec3::UnitZ()}));
  plan.colliders.push_back(collider("sheet", scene::MeshObstacle{sheet, false, 0.0}));
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
  run_to(*simulation, 0.5);
  EXPECT_GE(least(*simulation, 0), CELL * (1.0 - 1e-3)); // half of the least wall of two cells
}

TEST(Walls, ASheetThatDeformsLiftsTheLoadAndKnowsItsSpeed) {
  // A level sheet whose vertices rise at 0.4 m/s, one half of them a quarter of a second later than the other.
  auto sheet = std::make_shared<geometry::SurfaceMesh>();
  sheet->vertices.resize(6, 3);
  sheet->vertices << -0.5, -0.5, 0, 0, -0.5, 0, 0.5, -0.5, 0, -0.5, 0.5, 0, 0, 0.5, 0, 0.5, 0.5, 0;
  sheet->triangles.resize(4, 3);
  sheet->triangles << 0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4;
  auto sequence = std::make_shared<scene::MeshSequence>();
  sequence->samples = {sheet->vertices, sheet->vertices, sheet->vertices};
  sequence->interval = 0.25;
  for (const int vertex : {0, 1, 3, 4})
    sequence->samples[1](vertex, 2) = 0.1;
  sequence->samples[2].col(2).setConstant(0.1);
  MpmPlan plan = loose_sand(Vec3(-0.08, -0.08, CELL), Vec3(0.08, 0.08, 0.08));
  plan.colliders.push_back(collider("sheet", scene::MeshObstacle{sheet, false, 0.0, sequence}));
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
  run_to(*simulation, 0.2);
  const auto height_of_sheet = [&](double time, double x) {
    const Points now = sequence->at(time);
    return now(1, 2) + std::max(0.0, x) / 0.5 * (now(2, 2) - now(1, 2));
  };
  const auto check_above = [&](double time) {
    const Points positions = channel_of(*simulation, 0, "position");
    for (Eigen::Index i = 0; i < positions.rows(); ++i) {
      // Half of the least wall of two cells.
      ASSERT_GT(positions(i, 2) - height_of_sheet(time, positions(i, 0)), CELL * (0.9 - 1e-3)) << time << " " << i;
    }
  };
  check_above(0.2);
  const Points velocities = channel_of(*simulation, 0, "velocity");
  EXPECT_NEAR(velocities.col(2).mean(), 0.37, 0.05) << "in the middle it rises at nearly 0.4 m/s";
  run_to(*simulation, 0.5);
  check_above(0.5);
}

TEST(Colliders, FastBallDoesNotPassThrough) {
  // 50 m/s on a wall of two cells: the step shortens.
  MpmPlan plan = loose_sand(Vec3(-0.06, -0.06, 0.3), Vec3(0.06, 0.06, 0.42));
  plan.gravity = Vec3::Zero();
  plan.bodies[0].initial_velocity = Vec3(0, 0, -50);
  scene::BoxObstacle slab;
  slab.size = Vec3(4, 4, 0.01);
  plan.colliders.push_back(collider("slab", slab));
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
  const Result<StepStats> first = simulation->step(1.0);
  ASSERT_TRUE(first.ok());
  EXPECT_EQ(first->limit, StepLimit::speed);
  run_to(*simulation, 0.02);
  EXPECT_GE(least(*simulation, 2), 0.0);
}

TEST(Colliders, BlockSlidesOnASlopeAsCoulombSays) {
  // A stiff block on a plane tilted by 30 degrees slides with g (sin - mu cos) for mu = .3, and stays for mu = .8.
  const double angle = std::numbers::pi / 6.0;
  const Vec3 along(std::cos(angle), 0, -std::sin(angle));
  for (const double friction : {0.3, 0.8}) {
    MpmPlan plan;
    plan.settings.cell = CELL;
    plan.settings.precision = Precision::f64;
    // Gravity is tilted in place of the plane.
    plan.gravity = 9.81 * Vec3(std::sin(angle), 0, -std::cos(angle));
    Material stiff = column_material();
    stiff.plasticity = Plasticity::none;
    stiff.youngs_modulus = {1e6, 1e6, 1e6};
    plan.bodies.push_back(box_of_matter(Vec3(-0.2, -0.1, 0), Vec3(0.2, 0.1, 0.06), CELL, 8, stiff));
    plan.colliders.push_back(collider("floor", scene::PlaneObstacle{Vec3::Zero(), Vec3::UnitZ()}, friction));
    const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
    run_to(*simulation, 0.3);
    const double acceleration = std::max(0.0, 9.81 * (std::sin(angle) - friction * std::cos(angle)));
    const double moved = channel_of(*simulation, 0, "position").col(0).mean();
    EXPECT_NEAR(moved, 0.5 * acceleration * 0.09, friction < 0.5 ? 0.05 * 0.5 * acceleration * 0.09 : 1e-3) << friction;
  }
}

TEST(HeldSpace, HoldsABarUntilItLetsGo) {
  MpmPlan plan;
  plan.gravity = Vec3(0, 0, -9.81);
  plan.settings.cell = CELL;
  Material elastic = column_material();
  elastic.plasticity = Plasticity::none;
  elastic.youngs_modulus = {1e6, 1e6, 1e6};
  plan.bodies.push_back(box_of_matter(Vec3(0, 0, 0), Vec3(0.2, 0.08, 0.08), CELL, 8, elastic));
  scene::BoxObstacle grip;
  grip.centre = Vec3(0, 0.04, 0.04);
  grip.size = Vec3(0.1, 0.2, 0.2);
  plan.held.push_back({"grip", grip, {}, 0.1});
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
  run_to(*simulation, 0.1);
  const Points held = channel_of(*simulation, 0, "position");
  EXPECT_GT(held.row(0).z(), -1e-3);
  run_to(*simulation, 0.3);
  const double fallen = held.col(2).mean() - channel_of(*simulation, 0, "position").col(2).mean();
  EXPECT_NEAR(fallen, 0.5 * 9.81 * 0.04, 0.02);
}

TEST(Sources, AddTheirParticlesWhenTheyAreDue) {
  MpmPlan plan = loose_sand(Vec3(0, 0, 0.5), Vec3(0.08, 0.08, 0.54));
  plan.bodies[0].initial_velocity = Vec3(0, 0, -1);
  plan.sources.push_back({"stream", 0, 0.04, 0.04, 0.1});
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
  const std::size_t once = simulation->particle_count();
  run_to(*simulation, 0.2);
  EXPECT_EQ(simulation->particle_count(), 3 * once); // at 0, .04 and .08 s
  const Points x = channel_of(*simulation, 0, "position");
  EXPECT_EQ(static_cast<std::size_t>(x.rows()), 3 * once);
  EXPECT_TRUE(x.allFinite());
  // The first have fallen furthest.
  const Eigen::Index n = static_cast<Eigen::Index>(once);
  EXPECT_LT(x.topRows(n).col(2).mean(), x.bottomRows(n).col(2).mean() - 0.05);
}

} // namespace
} // namespace wry::mpm
