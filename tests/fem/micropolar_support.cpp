#include "tests/fem/micropolar_support.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sim/base/rotation.h"
#include "sim/geometry/structured_tets.h"

namespace wry::fem::test {

void record_number(const std::string& what, double required, double measured) {
  const char* folder = std::getenv("WRY_EVIDENCE");
  if (folder == nullptr)
    return;
  std::ofstream out(std::string(folder) + "/micropolar_numbers.csv", std::ios::app);
  out << what << ',' << fmt::format("{:.6g},{:.6g},{:.3g}", required, measured, measured / required - 1.0) << '\n';
}

FemPlan curving_bar(double width, double length, int n, int nz, double length_scale, double bending, double torsion) {
  const std::shared_ptr<const geometry::TetMesh> mesh =
      box_mesh(Vec3(-width / 2, -width / 2, 0), Vec3(width, width, length), n, n, nz);
  FemPlan plan = plan_of(make_body(mesh, ElasticModel::micropolar, 2.0, 0.0));
  FemMaterial& material = plan.bodies[0].material;
  material.density = 1e-10;
  material.length_scale = length_scale;
  material.curvature = CurvatureModel::isotropic;
  plan.bodies[0].rest_curvature = [bending, torsion](const RestPlace&, double time) {
    Mat3 curvature = Mat3::Zero();
    curvature(0, 2) = time * bending;
    curvature(2, 2) = time * torsion;
    return curvature;
  };
  plan.fixed.push_back({"clamp", 0, vertices_at(*mesh, 2, 0.0), true, true, {}});
  plan.settings.newton_tolerance = 1e-13;
  plan.settings.linear_solver = LinearSolver::cholesky;
  return plan;
}

Vec3 measured_curvature(const FemPlan& plan, const FemSimulation& simulation, double length) {
  const Eigen::MatrixXd rotations = channel_of(simulation, "microrotation");
  const Points& rest = plan.bodies[0].mesh->vertices;
  Vec4 ends[2] = {identity_quaternion(), identity_quaternion()};
  for (Eigen::Index i = 0; i < rest.rows(); ++i) {
    for (int end = 0; end < 2; ++end) {
      if ((rest.row(i) - Eigen::RowVector3d(0, 0, (0.25 + 0.5 * end) * length)).norm() < 1e-9)
        ends[end] = rotations.row(i);
    }
  }
  return rotation_vector(quaternion_product(quaternion_conjugate(ends[0]), ends[1])) / (0.5 * length);
}

double curvature_ratio(double length_scale, int n) {
  FemPlan plan = curving_bar(1.0, 4.0, n, 4 * n, length_scale, 1e-4 / 4.0);
  plan.settings.max_time_step = 1.0;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  EXPECT_EQ(run_until(*simulation, 1.0), 1);
  return measured_curvature(plan, *simulation, 4.0).norm() / (1e-4 / 4.0);
}

double torsion_ratio(double length_scale, int n) {
  constexpr double TWIST = 1e-4; // [1/m]
  const double length = 4.0 / n; // the solution is the same all along; cells as long as they are wide
  const Result<geometry::TetMesh> made =
      geometry::make_block_tets(geometry::cylinder_block(1.0, length), {{n, 2, n}, geometry::CellSplit::kuhn_outward});
  if (!made) {
    ADD_FAILURE() << made.error().message;
    return 0.0;
  }
  const auto mesh = std::make_shared<const geometry::TetMesh>(*made);
  FemPlan plan = plan_of(make_body(mesh, ElasticModel::micropolar, 2.0, 0.0));
  FemMaterial& material = plan.bodies[0].material;
  material.density = 1e-10;
  material.length_scale = length_scale;
  material.curvature = CurvatureModel::isotropic;
  plan.settings.newton_tolerance = 1e-14;
  plan.settings.max_time_step = 1.0;
  plan.settings.linear_solver = LinearSolver::cholesky;
  for (const double side : {-0.5, 0.5}) {
    // Positions and turns about the axis are given at the ends; other turns are free, as in the closed form.
    DrivenNodes end;
    end.name = "end";
    end.nodes = vertices_at(*mesh, 1, side * length);
    end.driven_turns = {false, true, false};
    end.motion = scene::Motion::along_keys(
                     {{{0.0, Vec3::Zero(), Vec3::UnitY(), 0.0},
                       {1.0, Vec3::Zero(), Vec3::UnitY(), side * length * TWIST * 180.0 / std::numbers::pi}},
                      Vec3::Zero()})
                     .value();
    plan.driven.push_back(end);
  }
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  const Result<StepStats> stats = simulation->step(1.0);
  EXPECT_TRUE(stats) << stats.error().message;
  const double energy = stats->elastic_energy + stats->curvature_energy;
  return 2.0 * energy / (TWIST * TWIST * length) / (std::numbers::pi / 2.0);
}

} // namespace wry::fem::test
