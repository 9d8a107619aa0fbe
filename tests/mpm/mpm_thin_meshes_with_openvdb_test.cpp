#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "tests/mpm/mpm_support.h"
#include "tests/mpm/tank_support.h"

namespace wry::mpm {
namespace {

constexpr double CELL = 0.02;

std::shared_ptr<const scene::Collider> closed(geometry::SurfaceMesh mesh) {
  auto collider = std::make_shared<scene::Collider>();
  collider->name = "mesh";
  collider->shape = scene::MeshObstacle{std::make_shared<const geometry::SurfaceMesh>(std::move(mesh)), true, 0.0};
  return collider;
}

MpmPlan sand_in(const Vec3& low, const Vec3& high) {
  MpmPlan plan;
  plan.gravity = Vec3(0, 0, -9.81);
  plan.settings.cell = CELL;
  Material sand = column_material();
  sand.friction_angle = 0.3;
  plan.bodies.push_back(box_of_matter(low, high, CELL, 8, sand));
  return plan;
}

/// A plate of a tenth of a cell, between two rows of nodes, that no voxel sees.
TEST(ThinClosedMeshes, APlateOfATenthOfACellCarriesAHeap) {
  const double height = 0.5 * CELL;
  MpmPlan plan = sand_in(Vec3(-0.1, -0.1, 2 * CELL), Vec3(0.1, 0.1, 2 * CELL + 0.1));
  plan.colliders.push_back(closed(box_mesh(Vec3(-0.5, -0.5, height - 0.001), Vec3(0.5, 0.5, height + 0.001))));
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
  run_to(*simulation, 0.5);
  EXPECT_GE(channel_of(*simulation, 0, "position").col(2).minCoeff(), height);
}

/// Walls of a fifth of a cell, 4 mm, between rows of nodes.
TEST(ThinClosedMeshes, ATankOfThinWallsDoesNotLeak) {
  const Vec3 low(-0.131, -0.131, -0.011), high(0.131, 0.131, 0.3);
  constexpr double WALL = 0.004;
  MpmPlan plan = sand_in(Vec3(-0.1, -0.1, 0.02), Vec3(0.1, 0.1, 0.16));
  plan.colliders.push_back(closed(tank(low, high, WALL)));
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
  run_to(*simulation, 0.5);
  const Points x = channel_of(*simulation, 0, "position");
  EXPECT_GE(x.col(2).minCoeff(), low.z() + WALL);
  EXPECT_LE(x.leftCols(2).cwiseAbs().maxCoeff(), high.x() - WALL);
}

/// Grains meet the plate as it is drawn, not as thick as the grid needs it.
TEST(ThinClosedMeshes, GrainsThatFlyComeToLieOnThePlateItself) {
  const geometry::SurfaceMesh plate = box_mesh(Vec3(-0.5, -0.5, -0.011), Vec3(0.5, 0.5, -0.001));
  MpmPlan plan = sand_in(Vec3(-0.04, -0.04, 0.06), Vec3(0.04, 0.04, 0.1));
  plan.bodies[0].sub_particles.emplace();
  plan.bodies[0].sub_particles->name = "grains";
  plan.bodies[0].sub_particles->escape_density = plan.bodies[0].sub_particles->capture_density = 1e3; // all fly
  plan.colliders.push_back(closed(plate));
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
  run_to(*simulation, 0.6);
  const Points x = channel_of(*simulation, 1, "position");
  const double radius = 0.5 * 0.004;
  EXPECT_NEAR(quantile(x.col(2), 0.5), -0.001 + radius, 0.0015);
  EXPECT_GE(x.col(2).minCoeff(), -0.001);
}

} // namespace
} // namespace wry::mpm
