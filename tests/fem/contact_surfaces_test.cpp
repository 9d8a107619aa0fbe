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

/// A plate so many metres above where plate_body() has it.
FemBody plate_at(double height, double thickness, const std::string& name) {
  FemBody body = plate_body();
  std::shared_ptr<geometry::TetMesh> mesh = std::make_shared<geometry::TetMesh>(*body.mesh);
  mesh->vertices.col(1).array() += height;
  body.mesh = mesh;
  body.name = name;
  body.thickness = thickness;
  body.material.model = ElasticModel::micropolar;
  body.material.youngs_modulus = 2e5;
  body.material.density = 300.0;
  return body;
}

/// A level sheet at height 0 that is twice as wide as the plate.
scene::Collider thick_sheet(double thickness) {
  geometry::SurfaceMesh mesh;
  mesh.vertices.resize(4, 3);
  mesh.vertices << -0.1, 0, -0.1, -0.1, 0, 0.3, 0.3, 0, 0.3, 0.3, 0, -0.1;
  mesh.triangles.resize(2, 3);
  mesh.triangles << 0, 1, 2, 0, 2, 3;
  scene::Collider collider;
  collider.name = "table";
  collider.shape = scene::MeshObstacle{std::make_shared<geometry::SurfaceMesh>(mesh), false, thickness};
  return collider;
}

TEST(ContactSurfaces, PlatesAndThickSheetsLieOnEachOtherWithTheirThickness) {
  FemPlan plan;
  plan.bodies.push_back(plate_at(0.025, 0.01, "lower"));
  plan.bodies.push_back(plate_at(0.045, 0.02, "upper"));
  plan.obstacles.push_back(thick_sheet(0.03));
  plan.contact = ContactOptions{};
  plan.settings.contact_distance = 1e-3;
  plan.settings.newton_tolerance = 1e-6;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  ASSERT_NE(simulation, nullptr);
  run_until(*simulation, 0.3);
  // Half of the table, half of the lower; half of the lower, half of the upper. At most d-hat is left between.
  const Points lower = positions_of(*simulation, 0);
  const Points upper = positions_of(*simulation, 1);
  EXPECT_GT(lower.col(1).minCoeff(), 0.015 + 0.005);
  EXPECT_LT(lower.col(1).maxCoeff(), 0.015 + 0.005 + 1e-3);
  EXPECT_GT((upper.col(1) - lower.col(1)).minCoeff(), 0.005 + 0.01);
  EXPECT_LT((upper.col(1) - lower.col(1)).maxCoeff(), 0.005 + 0.01 + 1e-3);
}

TEST(ContactSurfaces, APlateLiesOnAPlaneWithHalfItsThickness) {
  FemPlan plan;
  plan.bodies.push_back(plate_at(0.01, 0.01, "plate"));
  plan.planes.push_back({"ground", Vec3::Zero(), Vec3::UnitY(), 0.5});
  plan.settings.contact_distance = 1e-3;
  plan.settings.newton_tolerance = 1e-6;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  ASSERT_NE(simulation, nullptr);
  run_until(*simulation, 0.3);
  EXPECT_GT(positions_of(*simulation).col(1).minCoeff(), 0.005);
  EXPECT_LT(positions_of(*simulation).col(1).maxCoeff(), 0.006);
}

TEST(ContactSurfaces, PlatesThatStartNearerThanTheyAreThickAreRefusedByName) {
  FemPlan plan;
  plan.bodies.push_back(plate_at(0.0, 0.01, "lower"));
  plan.bodies.push_back(plate_at(0.014, 0.02, "upper"));
  plan.contact = ContactOptions{};
  const Result<std::unique_ptr<FemSimulation>> simulation = FemSimulation::create(plan, 1, native_isa());
  ASSERT_FALSE(simulation);
  EXPECT_EQ(simulation.error().code, ErrorCode::bad_input);
  EXPECT_NE(simulation.error().message.find("body 'lower' and body 'upper' are together 0.015 m thick, but 0.001 m"),
            std::string::npos)
      << simulation.error().message;
}

TEST(ContactSurfaces, APlateThickerThanItsEdgesIsAtRestWhereItRests) {
  FemPlan plan;
  plan.bodies.push_back(plate_at(0.0, 0.05, "thick")); // its edges are 0.033
  plan.contact = ContactOptions{};
  plan.gravity.setZero();
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  ASSERT_NE(simulation, nullptr);
  const Points before = positions_of(*simulation);
  run_until(*simulation, 0.1);
  EXPECT_LT((positions_of(*simulation) - before).cwiseAbs().maxCoeff(), 1e-12);
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
