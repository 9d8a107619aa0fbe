#include <gtest/gtest.h>

#include "sim/geometry/sheet_triangles.h"
#include "tests/fem/contact_scene_support.h"

namespace wry::fem {
namespace {

using namespace test;

/// A body of some kind of element that falls onto a ball.
FemPlan onto_a_ball(FemBody body) {
  FemPlan plan;
  body.name = "body";
  body.material.model = ElasticModel::micropolar;
  body.material.youngs_modulus = 2e5;
  body.material.density = 300.0;
  plan.bodies.push_back(std::move(body));
  scene::Collider ball;
  ball.name = "ball";
  ball.shape = scene::SphereObstacle{Vec3(0.1, -0.105, 0.1), 0.1};
  ball.friction = 0.5;
  plan.obstacles.push_back(ball);
  plan.settings.newton_tolerance = 1e-6;
  return plan;
}

FemBody plate_body() {
  const Result<geometry::SheetTriangles> sheet =
      geometry::make_sheet_triangles(0.2, 0.2, 6, 6, geometry::SheetSplit::alternating);
  FemBody body;
  std::shared_ptr<geometry::TetMesh> mesh = std::make_shared<geometry::TetMesh>();
  mesh->vertices = sheet->mesh.vertices;
  mesh->vertices.rowwise() += Eigen::RowVector3d(0.1, 0.0, 0.1);
  body.mesh = mesh;
  body.triangles = sheet->triangles;
  body.element = ElementKind::plate3;
  body.thickness = 0.004;
  return body;
}

double highest_after_landing(const FemPlan& plan) {
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  if (!simulation)
    return -1e300;
  run_until(*simulation, 0.2);
  return positions_of(*simulation).col(1).maxCoeff();
}

TEST(ContactSurfaces, PlatesLieOnABall) {
  for (const bool quadratic : {false, true}) {
    FemBody body = quadratic ? with_midpoints(plate_body()) : plate_body();
    const double height = highest_after_landing(onto_a_ball(std::move(body)));
    // The ball's top is at -0.005; its facets, of 0.07 m, are up to 0.006 below. Without it the plate falls by 0.2 m.
    EXPECT_GT(height, -0.011) << quadratic;
    EXPECT_LT(height, 0.01) << quadratic;
  }
}

TEST(ContactSurfaces, BodiesOfQuadraticTetsLieOnABallWithTheirMidpointsOutside) {
  FemBody body = with_midpoints(
      make_body(box_mesh(Vec3(0, 0, 0), Vec3(0.2, 0.02, 0.2), 4, 1, 4), ElasticModel::micropolar, 2e5, 0.3));
  const FemPlan plan = onto_a_ball(std::move(body));
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  ASSERT_NE(simulation, nullptr);
  run_until(*simulation, 0.2);
  const Points positions = positions_of(*simulation);
  EXPECT_GT(positions.col(1).maxCoeff(), 0.0);
  // The ball is drawn with facets, a little inside it.
  for (Eigen::Index i = 0; i < positions.rows(); ++i)
    ASSERT_GT((positions.row(i).transpose() - Vec3(0.1, -0.105, 0.1)).norm(), 0.09) << i;
}

} // namespace
} // namespace wry::fem
