#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "sim/geometry/closest_point_tree.h"
#include "tests/mpm/mpm_support.h"
#include "tests/mpm/tank_support.h"

namespace wry::mpm {
namespace {

constexpr double CELL = 0.02;
constexpr double THICKNESS = 0.004, LENGTH = 0.016; ///< of a rod

/// A bed that is open above and tips by 50 degrees about its rear edge, over a floor at z = 0.
struct Tipping {
  std::shared_ptr<const geometry::SurfaceMesh> bed =
      std::make_shared<const geometry::SurfaceMesh>(tank(Vec3(-0.1, -0.3, 0.1), Vec3(0.1, 0.0, 0.2), 0.015));
  scene::Motion motion;
  MpmPlan plan;

  Tipping() {
    scene::MotionKeys keys;
    keys.pivot = Vec3(0, 0, 0.1);
    keys.keys = {{0.05, Vec3::Zero(), Vec3::UnitX(), 0}, {0.4, Vec3::Zero(), Vec3::UnitX(), -50}};
    motion = *scene::Motion::along_keys(keys);
    plan.gravity = Vec3(0, 0, -9.81);
    plan.settings.cell = CELL;
    Material straw = column_material();
    straw.friction_angle = 0.4;
    plan.bodies.push_back(box_of_matter(Vec3(-0.08, -0.28, 0.116), Vec3(0.08, -0.06, 0.18), CELL, 4, straw));
    plan.bodies[0].sub_particles.emplace();
    SubParticleSettings& grains = *plan.bodies[0].sub_particles;
    grains.name = "grains";
    grains.size = Vec3(THICKNESS, THICKNESS, LENGTH);
    auto floor = std::make_shared<scene::Collider>();
    floor->name = "floor";
    floor->shape = scene::PlaneObstacle{Vec3::Zero(), Vec3::UnitZ()};
    auto truck = std::make_shared<scene::Collider>();
    truck->name = "bed";
    truck->shape = scene::MeshObstacle{bed, true, 0.0};
    truck->motion = motion;
    truck->friction = 0.3;
    plan.colliders = {floor, truck};
  }
};

/// Distance to the bed and the floor as they are drawn, negative inside.
double drawn_distance(const geometry::ClosestPointTree& bed, const scene::Pose& pose, const Vec3& point) {
  return std::min(point.z(), bed.signed_distance(pose.apply_inverse(point)));
}

/// Gaps below grains that stand still with no other within a grain's length beneath them [m].
std::vector<double> gaps(const Points& x, const Points& v, const geometry::ClosestPointTree& bed,
                         const scene::Pose& pose) {
  std::vector<double> found;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    if (v.row(i).norm() > 0.02)
      continue;
    const Points away = x.rowwise() - x.row(i);
    const auto beneath = away.col(2).array() < -0.05 * LENGTH && away.rowwise().norm().array() < LENGTH;
    if (beneath.count() == 0)
      found.push_back(drawn_distance(bed, pose, x.row(i)) - 0.5 * THICKNESS);
  }
  return found;
}

TEST(GrainsOnMeshes, AreInsideNothingOnAnyFrameAndHoverOverNothing) {
  const Tipping tipping;
  const std::unique_ptr<MpmSimulation> simulation = make(tipping.plan);
  const geometry::ClosestPointTree bed(*tipping.bed);
  constexpr int FRAMES = 60;
  constexpr double FPS = 40.0;
  for (int frame = 0; frame <= FRAMES; ++frame) {
    if (frame > 0)
      run_to(*simulation, frame / FPS);
    const scene::Pose pose = tipping.motion.pose(frame / FPS);
    const Points x = channel_of(*simulation, 1, "position");
    for (Eigen::Index i = 0; i < x.rows(); ++i)
      ASSERT_GE(drawn_distance(bed, pose, x.row(i)), 0.0) << "frame " << frame << ", grain " << i;
  }
  const Points x = channel_of(*simulation, 1, "position"), v = channel_of(*simulation, 1, "velocity");
  EXPECT_GT((x.col(1).array() > 0.0).count(), x.rows() / 4) << "the bed was not emptied";
  const auto still = (v.rowwise().norm().array() <= 0.02).count();
  const std::vector<double> below = gaps(x, v, bed, tipping.motion.pose(FRAMES / FPS));
  const auto hovering = std::count_if(below.begin(), below.end(), [](double gap) { return gap > LENGTH; });
  std::printf("%td of %td grains stand still, %zu of them on no other, %td of those hover\n", still, x.rows(),
              below.size(), hovering);
  EXPECT_GT(still, x.rows() / 20);
  EXPECT_GT(below.size(), 20u);
  EXPECT_LE(static_cast<double>(hovering), 0.01 * static_cast<double>(below.size())); // at the top of a bounce
}

} // namespace
} // namespace wry::mpm
