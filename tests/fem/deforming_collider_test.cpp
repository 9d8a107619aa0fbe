#include <cmath>

#include <gtest/gtest.h>

#include "sim/contact/crossings.h"
#include "sim/geometry/tet_mesh.h"
#include "tests/fem/contact_scene_support.h"

namespace wry::fem {
namespace {

using namespace test;

constexpr int CELLS = 10;
constexpr double SIDE = 0.4;

/// A level sheet about the origin, at height 0.
geometry::SurfaceMesh level_sheet() {
  geometry::SurfaceMesh mesh;
  mesh.vertices.resize((CELLS + 1) * (CELLS + 1), 3);
  mesh.triangles.resize(2 * CELLS * CELLS, 3);
  for (int i = 0; i <= CELLS; ++i) {
    for (int k = 0; k <= CELLS; ++k)
      mesh.vertices.row(i * (CELLS + 1) + k) << SIDE * i / CELLS - 0.5 * SIDE, 0.0, SIDE * k / CELLS - 0.5 * SIDE;
  }
  for (int i = 0; i < CELLS; ++i) {
    for (int k = 0; k < CELLS; ++k) {
      const int corner = i * (CELLS + 1) + k;
      mesh.triangles.row(2 * (i * CELLS + k)) << corner, corner + 1, corner + CELLS + 2;
      mesh.triangles.row(2 * (i * CELLS + k) + 1) << corner, corner + CELLS + 2, corner + CELLS + 1;
    }
  }
  return mesh;
}

/// The sheet as it goes from sample to sample, `interval` seconds each.
scene::Collider deforming(const std::vector<Points>& samples, double interval, double friction = 0.0) {
  auto sequence = std::make_shared<scene::MeshSequence>();
  sequence->samples = samples;
  sequence->interval = interval;
  scene::Collider collider;
  collider.name = "sheet";
  collider.friction = friction;
  collider.shape =
      scene::MeshObstacle{std::make_shared<geometry::SurfaceMesh>(level_sheet()), false, 0.0, std::move(sequence)};
  return collider;
}

/// The sheet with a round bulge of a height in its middle.
Points bulged(double height) {
  Points vertices = level_sheet().vertices;
  for (Eigen::Index i = 0; i < vertices.rows(); ++i) {
    const double away = std::hypot(vertices(i, 0), vertices(i, 2));
    vertices(i, 1) = height * std::exp(-away * away / 0.01);
  }
  return vertices;
}

FemPlan box_over(const scene::Collider& sheet) {
  FemPlan plan;
  plan.bodies.push_back(box_body("box", Vec3(-0.05, 0.005, -0.05), Vec3(0.1, 0.1, 0.1), {2, 2, 2}, 1e5));
  plan.obstacles.push_back(sheet);
  plan.settings.max_time_step = 0.01;
  return plan;
}

/// Whether the body and the collider intersect now, exactly.
bool intersects(const FemPlan& plan, const FemSimulation& simulation) {
  contact::Surface surface;
  const auto rows_of = [](const Triangles& triangles) {
    std::vector<contact::Surface::Triangle> rows;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
      rows.push_back({triangles(t, 0), triangles(t, 1), triangles(t, 2)});
    return rows;
  };
  const Points body = positions_of(simulation);
  const auto& mesh = std::get<scene::MeshObstacle>(plan.obstacles[0].shape);
  const Points sheet = mesh.sequence->at(simulation.time());
  surface.add_part(static_cast<int>(body.rows()), rows_of(geometry::boundary_triangles(*plan.bodies[0].mesh)));
  surface.add_part(static_cast<int>(sheet.rows()), rows_of(mesh.mesh->triangles));
  surface.let_meet(0, 1);
  Points all(body.rows() + sheet.rows(), 3);
  all << body, sheet;
  return !contact::find_crossings(surface, all, Threads(1), 1).empty();
}

TEST(DeformingCollider, ABulgeLiftsTheBodyThatLiesOnIt) {
  // The bulge rises by 0.1 m in four samples, a twentieth of a second each.
  const FemPlan plan = box_over(deforming({bulged(0.0), bulged(0.02), bulged(0.05), bulged(0.08), bulged(0.1)}, 0.05));
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  ASSERT_NE(simulation, nullptr);
  while (simulation->time() < 0.2) {
    const Result<StepStats> stats = simulation->step(0.2);
    ASSERT_TRUE(stats) << stats.error().message;
    ASSERT_FALSE(intersects(plan, *simulation)) << simulation->time();
  }
  const Points positions = positions_of(*simulation);
  EXPECT_GT(positions.col(1).maxCoeff(), 0.19) << "its top was at 0.105";
}

TEST(DeformingCollider, CarriesByFrictionWhatLiesOnIt) {
  std::vector<Points> samples = {level_sheet().vertices, level_sheet().vertices};
  samples[1].col(0).array() += 0.15; // 0.3 m/s for half a second
  const FemPlan plan = box_over(deforming(samples, 0.5, 1.0));
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  ASSERT_NE(simulation, nullptr);
  run_until(*simulation, 0.4);
  EXPECT_NEAR(velocity_of(plan, *simulation, 0).x(), 0.3, 0.01);
}

TEST(DeformingCollider, AJumpThroughABodyPushesItOrStopsTheRun) {
  for (const double interval : {0.05, 0.001}) {
    FemPlan plan = box_over(deforming({bulged(0.0), bulged(0.0), bulged(0.4)}, interval));
    plan.settings.min_time_step = 1e-5;
    const std::unique_ptr<FemSimulation> simulation = simulate(plan);
    ASSERT_NE(simulation, nullptr);
    bool stopped = false;
    while (!stopped && simulation->time() < 3.0 * interval) {
      const Result<StepStats> stats = simulation->step(3.0 * interval);
      stopped = !stats;
      if (stopped) {
        EXPECT_NE(stats.error().message.find("last good state is kept"), std::string::npos) << stats.error().message;
      }
      ASSERT_FALSE(intersects(plan, *simulation)) << interval << " " << simulation->time();
    }
    EXPECT_GT(simulation->time(), 0.0);
  }
}

TEST(DeformingCollider, GivesTheSameBitsOnAnyNumberOfThreads) {
  const FemPlan plan = box_over(deforming({bulged(0.0), bulged(0.05), bulged(0.02)}, 0.05, 0.5));
  Points first;
  for (const int threads : {1, 2, 3}) {
    Result<std::unique_ptr<FemSimulation>> simulation = FemSimulation::create(plan, threads, native_isa());
    ASSERT_TRUE(simulation) << simulation.error().message;
    run_until(**simulation, 0.1);
    const Points positions = positions_of(**simulation);
    if (threads == 1)
      first = positions;
    EXPECT_TRUE(positions == first) << threads;
  }
}

} // namespace
} // namespace wry::fem
