#include <cmath>
#include <cstdio>
#include <numbers>

#include <gtest/gtest.h>

#include "sim/geometry/sheet_triangles.h"
#include "tests/fem/element_studies_support.h"
#include "tests/fem/solid_support.h"

namespace wry::fem {
namespace {

using namespace test;

TEST(ElementAccuracy, QuadraticTetsBendAsTheClosedFormWhereLinearOnesAreTooStiff) {
  const Bending quadratic = bend_bar(ElasticModel::micropolar, ElementKind::tet10, 1, 1.0);
  const Bending linear = bend_bar(ElasticModel::micropolar, ElementKind::tet4, 3, 1.0);
  std::printf("tet10, 1 cell: %.4f of the deflection, %d unknowns; tet4, 3 cells: %.4f, %d unknowns\n", quadratic.ratio,
              quadratic.unknowns, linear.ratio, linear.unknowns);
  EXPECT_NEAR(quadratic.ratio, 1.0, 0.02);
  EXPECT_LT(linear.ratio, 0.8);
  EXPECT_LT(quadratic.unknowns, linear.unknowns);
  const Bending finer = bend_bar(ElasticModel::micropolar, ElementKind::tet10, 2, 1.0);
  EXPECT_NEAR(finer.ratio, 1.0, 0.01); // the clamp holds a little more than the closed form has it
}

TEST(ElementAccuracy, CondensedMicrorotationsConvergeToTheSameBending) {
  // The corotated model, and microrotations that minimise the same energy: one stiffness, two discretisations.
  const double solved = bend_bar(ElasticModel::micropolar, ElementKind::tet4, 4, 1.0).ratio;
  const double condensed = bend_bar(ElasticModel::corotated, ElementKind::tet4, 4, 1.0).ratio;
  EXPECT_GT(condensed, solved); // a rotation per element constrains less than one that is continuous
  EXPECT_LT(condensed, 1.0);
  EXPECT_NEAR(condensed, solved, 0.1);
}

TEST(ElementAccuracy, LinearPlatesLockAndQuadraticOnesDoNot) {
  for (const double thickness : {0.1, 0.01, 0.001}) {
    const double linear = bend_plate(ElementKind::plate3, 8, thickness).ratio;
    const double quadratic = bend_plate(ElementKind::plate6, 8, thickness).ratio;
    std::printf("thickness %g: tri3 %.4f, tri6 %.4f of the deflection\n", thickness, linear, quadratic);
    EXPECT_NEAR(quadratic, 1.0, 0.05) << thickness;
    if (thickness < 0.05) {
      EXPECT_LT(linear, 0.3) << thickness;
    }
  }
}

TEST(ElementAccuracy, PlatesOfTetsResistByTheLengthScale) {
  constexpr double NU = 0.3;
  for (const double length_scale : {0.2, 0.5, 1.0}) {
    const double exact = 1.0 + 3.0 * (1.0 - NU) * 2.0 * length_scale * length_scale;
    // The error is of second order in the cells: extrapolated from two of them.
    for (const ElementKind element : {ElementKind::tet4, ElementKind::tet10}) {
      const int n = element == ElementKind::tet4 ? 4 : 1;
      const double coarse = plate_stiffness_ratio(element, n, NU, length_scale);
      const double fine = plate_stiffness_ratio(element, 2 * n, NU, length_scale);
      // What extrapolates is the stiffness that is added to that of curvature: 1 / (ratio - 1).
      const double inverse = (4.0 / (fine - 1.0) - 1.0 / (coarse - 1.0)) / 3.0;
      const double extrapolated = 1.0 + 1.0 / inverse;
      std::printf("L_c/h %g, %s: %.5f, %.5f, extrapolated %.5f; closed form %.5f (%+.2f %%)\n", length_scale,
                  element == ElementKind::tet4 ? "tet4" : "tet10", coarse, fine, extrapolated, exact,
                  100.0 * (extrapolated / exact - 1.0));
      EXPECT_NEAR(extrapolated / exact, 1.0, 0.02) << length_scale;
    }
  }
}

/// A quarter of a cylinder of radius 1 around z, as a plate; clamped at angle 0, where it stands along x.
FemPlan quarter_cylinder(int cells) {
  const geometry::SheetTriangles sheet =
      *geometry::make_sheet_triangles(1.0, 0.2, cells, 2, geometry::SheetSplit::alternating);
  std::shared_ptr<geometry::TetMesh> mesh = std::make_shared<geometry::TetMesh>(sheet.mesh);
  for (Eigen::Index i = 0; i < mesh->vertices.rows(); ++i) {
    const double angle = (mesh->vertices(i, 0) + 0.5) * 0.5 * std::numbers::pi;
    mesh->vertices.row(i) << std::sin(angle), 1.0 - std::cos(angle), mesh->vertices(i, 2);
  }
  FemBody body = make_body(mesh, ElasticModel::micropolar, 1e6, 0.0);
  body.element = ElementKind::plate3;
  body.triangles = sheet.triangles;
  body.thickness = 0.02;
  body.material.density = 1e-6;
  FemPlan plan = plan_of(with_midpoints(std::move(body)));
  plan.fixed.push_back({"clamp", 0, vertices_at(*plan.bodies[0].mesh, 0, 0.0), true, true, {}});
  plan.settings.linear_solver = LinearSolver::cholesky;
  return plan;
}

TEST(ElementAccuracy, CurvedPlatesAreAtRestInTheirRestShape) {
  const FemPlan plan = quarter_cylinder(8);
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  run_until(*simulation, 0.1);
  const Points moved = positions_of(*simulation) - plan.bodies[0].mesh->vertices;
  EXPECT_LT(moved.cwiseAbs().maxCoeff(), 1e-12);
}

TEST(ElementAccuracy, RestCurvatureUnrollsACurvedPlate) {
  double last = 0.0;
  for (const int cells : {8, 16, 32}) {
    FemPlan plan = quarter_cylinder(cells);
    // Against the curvature 1 of the cylinder, about z while moving along its arc.
    plan.bodies[0].rest_curvature = [](const RestPlace& at, double time) {
      const Vec3& place = at.position;
      const Vec3 along = Vec3(1.0 - place[1], place[0], 0.0).normalized();
      return Mat3(-std::min(time, 1.0) * Vec3::UnitZ() * along.transpose());
    };
    plan.settings.max_time_step = 0.2;
    const std::unique_ptr<FemSimulation> simulation = simulate(plan);
    run_until(*simulation, 1.4);
    const Points positions = positions_of(*simulation);
    const Eigen::MatrixXd turns = channel_of(*simulation, "microrotation");
    Eigen::Index tip = 0;
    plan.bodies[0].mesh->vertices.col(1).maxCoeff(&tip);
    const double turn = 2.0 * std::atan2(turns(tip, 3), turns(tip, 0));
    const double error = std::abs(turn / (-0.5 * std::numbers::pi) - 1.0);
    std::printf("%d cells: tip at %.4f, %.4f (pi/2, 0 when unrolled), turned by %.4f (-pi/2)\n", cells,
                positions(tip, 0), positions(tip, 1), turn);
    if (cells == 32) {
      EXPECT_NEAR(positions(tip, 0), 0.5 * std::numbers::pi, 2e-3);
      EXPECT_NEAR(positions(tip, 1), 0.0, 5e-3);
      EXPECT_LT(error, 3e-3);
    }
    if (cells > 8) {
      EXPECT_LT(error, last / 3.0);
    }
    last = error;
  }
}

TEST(ElementAccuracy, AStretchLimitHoldsASoftMembrane) {
  // A strip under its own weight: without a limit it more than doubles its length.
  double length[2];
  for (int limited = 0; limited < 2; ++limited) {
    const geometry::SheetTriangles sheet =
        *geometry::make_sheet_triangles(1.0, 0.25, 8, 2, geometry::SheetSplit::alternating);
    FemBody body = make_body(std::make_shared<geometry::TetMesh>(sheet.mesh), ElasticModel::micropolar, 1e4, 0.3);
    body.element = ElementKind::plate3;
    body.triangles = sheet.triangles;
    body.thickness = 0.001;
    if (limited == 1)
      body.material.max_stretch = 1.1;
    FemPlan plan = plan_of(std::move(body));
    plan.fixed.push_back({"clamp", 0, vertices_at(*plan.bodies[0].mesh, 0, -0.5), true, true, {}});
    plan.gravity = Vec3(20.0, 0.0, 0.0);
    plan.settings.max_time_step = 0.05;
    plan.settings.linear_solver = LinearSolver::cholesky;
    const std::unique_ptr<FemSimulation> simulation = simulate(plan);
    run_until(*simulation, 20.0);
    length[limited] = positions_of(*simulation).col(0).maxCoeff() + 0.5;
  }
  std::printf("length of a hanging membrane: %.3f, with max_stretch = 1.1: %.3f\n", length[0], length[1]);
  EXPECT_GT(length[0], 1.8);
  EXPECT_LT(length[1], 1.12);
}

TEST(ElementAccuracy, OnePointLeavesRotationsThatCostNothing) {
  const double one_point = spin_roughness(ElementKind::tet4_one_point, 1.0);
  const double four_points = spin_roughness(ElementKind::tet4, 1.0);
  std::printf("roughness of the rotations after 1 s: one point %.4f rad, four points %.4f rad\n", one_point,
              four_points);
  EXPECT_GT(one_point, 5.0 * four_points);
}

} // namespace
} // namespace wry::fem
