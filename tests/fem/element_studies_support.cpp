#include "tests/fem/element_studies_support.h"

#include <cmath>
#include <ctime>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "sim/base/rotation.h"
#include "sim/geometry/sheet_triangles.h"
#include "tests/fem/solid_support.h"

namespace wry::fem::test {

namespace {

FemBody with_element(FemBody body, ElementKind element) {
  if (is_quadratic(element))
    return with_midpoints(std::move(body));
  body.element = element;
  return body;
}

/// One static step of a plan; the mean of a coordinate over some vertices of its only body, before and after.
Bending solve(FemPlan plan, const std::vector<std::int32_t>& tip, int axis, double expected) {
  plan.settings.max_time_step = 1e3;
  plan.settings.newton_tolerance = 1e-12;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  Bending result;
  const std::clock_t start = std::clock();
  const Result<StepStats> stats = simulation->step(1e3);
  result.cpu_seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  if (!stats) {
    ADD_FAILURE() << stats.error().message;
    return result;
  }
  const Points moved = positions_of(*simulation) - plan.bodies[0].mesh->vertices;
  double sum = 0.0;
  for (const std::int32_t vertex : tip)
    sum += moved(vertex, axis);
  result.ratio = sum / static_cast<double>(tip.size()) / expected;
  result.unknowns = static_cast<int>(simulation->dof_count()) - 3 * static_cast<int>(plan.bodies[0].edges.size());
  result.iterations = stats->newton_iterations;
  return result;
}

} // namespace

Bending bend_bar(ElasticModel model, ElementKind element, int cells, double couple_modulus_ratio, LinearSolver solver) {
  constexpr double LENGTH = 8.0;
  FemBody body = make_body(box_mesh(Vec3::Zero(), Vec3(LENGTH, 1, 1), static_cast<int>(LENGTH) * cells, cells, cells),
                           model, 1.0, 0.0);
  body.material.couple_modulus_ratio = couple_modulus_ratio;
  body.material.density = 1.0;
  FemPlan plan = plan_of(with_element(std::move(body), element));
  plan.settings.linear_solver = solver;
  const geometry::TetMesh& mesh = *plan.bodies[0].mesh;
  plan.fixed.push_back({"clamp", 0, vertices_at(mesh, 0, 0.0), true, true, {}});
  const double load = 1e-6 / 6.0; // per length
  plan.gravity = Vec3(0, -load, 0);
  const double bent = load * std::pow(LENGTH, 4) / (8.0 / 12.0);
  const double sheared = load * LENGTH * LENGTH / (2.0 * (5.0 / 6.0) * 0.5);
  return solve(plan, vertices_at(mesh, 0, LENGTH), 1, -(bent + sheared));
}

Bending bend_plate(ElementKind element, int cells_along, double thickness) {
  constexpr double MODULUS = 1e9; // forces far above Newton tolerance and inertia, however thin the plate
  const geometry::SheetTriangles sheet = *geometry::make_sheet_triangles(
      1.0, 0.25, cells_along, std::max(1, cells_along / 4), geometry::SheetSplit::alternating);
  FemBody body = make_body(std::make_shared<geometry::TetMesh>(sheet.mesh), ElasticModel::micropolar, MODULUS, 0.0);
  body.element = ElementKind::plate3;
  body.triangles = sheet.triangles;
  body.thickness = thickness;
  body.material.density = 1.0;
  if (element == ElementKind::plate6)
    body = with_midpoints(std::move(body));
  FemPlan plan = plan_of(std::move(body));
  plan.settings.linear_solver = LinearSolver::cholesky;
  const geometry::TetMesh& mesh = *plan.bodies[0].mesh;
  plan.fixed.push_back({"clamp", 0, vertices_at(mesh, 0, -0.5), true, true, {}});
  // A deflection of a thousandth of the length: linear.
  const double stiffness = MODULUS * thickness * thickness * thickness / 12.0; // nu = 0
  const double load = 1e-3 * 8.0 * stiffness;
  plan.gravity = Vec3(0, -load / thickness, 0);
  const double bent = load / (8.0 * stiffness);
  const double sheared = load / (2.0 * MODULUS * thickness); // mu + mu_c = E
  return solve(plan, vertices_at(mesh, 0, 0.5), 1, -(bent + sheared));
}

double plate_stiffness_ratio(ElementKind element, int cells, double poisson_ratio, double length_scale) {
  constexpr double LENGTH = 4.0, REST = 1e-4 / LENGTH;
  FemBody body = make_body(
      box_mesh(Vec3(0, -0.5 / cells, -0.5), Vec3(LENGTH, 1.0 / cells, 1.0), static_cast<int>(LENGTH) * cells, 1, cells),
      ElasticModel::micropolar, 2.0 * (1.0 + poisson_ratio), poisson_ratio);
  body.material.density = 1e-10;
  body.material.length_scale = length_scale;
  body.material.curvature = CurvatureModel::isotropic;
  body.rest_curvature = [](const RestPlace&, double) {
    Mat3 curvature = Mat3::Zero();
    curvature(1, 0) = REST;
    return curvature;
  };
  FemPlan plan = plan_of(with_element(std::move(body), element));
  const geometry::TetMesh& mesh = *plan.bodies[0].mesh;
  plan.fixed.push_back({"clamp", 0, vertices_at(mesh, 0, 0.0), true, true, {}});
  // Plane strain: the sides stay in their planes.
  for (const double side : {-0.5 / cells, 0.5 / cells}) {
    FixedNodes held{"side", 0, vertices_at(mesh, 1, side), true, false, {}};
    held.axes = {false, true, false};
    plan.fixed.push_back(held);
  }
  plan.settings.max_time_step = 1.0;
  plan.settings.newton_tolerance = 1e-13;
  plan.settings.linear_solver = LinearSolver::cholesky;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  run_until(*simulation, 1.0);
  const Eigen::MatrixXd q = channel_of(*simulation, "microrotation");
  // Mean turn about y of the sections at a quarter and at three quarters.
  double turn[2] = {0.0, 0.0};
  for (int end = 0; end < 2; ++end) {
    int count = 0;
    for (const std::int32_t vertex : vertices_at(mesh, 0, (0.25 + 0.5 * end) * LENGTH)) {
      if (std::abs(mesh.vertices(vertex, 2)) > 1e-9)
        continue;
      turn[end] += 2.0 * std::atan2(q(vertex, 2), q(vertex, 0));
      ++count;
    }
    turn[end] /= count;
  }
  const double curvature = (turn[1] - turn[0]) / (0.5 * LENGTH);
  return 1.0 / (1.0 - curvature / REST);
}

double spin_roughness(ElementKind element, double time) {
  FemBody body = make_body(box_mesh(Vec3::Zero(), Vec3(2, 0.5, 0.5), 8, 2, 2), ElasticModel::micropolar, 1e4, 0.3);
  body.material.rotary_inertia = 10.0;
  FemPlan plan = plan_of(with_element(std::move(body), element));
  const geometry::TetMesh& mesh = *plan.bodies[0].mesh;
  for (const double end : {0.0, 2.0})
    plan.fixed.push_back({"end", 0, vertices_at(mesh, 0, end), true, true, {}});
  plan.settings.linear_solver = LinearSolver::cholesky;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  StateArchive archive = simulation->archive();
  std::mt19937 random(1u);
  for (NamedArray& array : archive) {
    if (array.name != "fem/body0/angular_velocities")
      continue;
    for (double& value : array.values)
      value = 2.0 * (static_cast<double>(random()) / 4294967296.0 - 0.5);
  }
  EXPECT_TRUE(simulation->restore(archive));
  run_until(*simulation, time);
  const Eigen::MatrixXd q = channel_of(*simulation, "microrotation");
  double sum = 0.0;
  int count = 0;
  for (Eigen::Index tet = 0; tet < mesh.tets.rows(); ++tet) {
    for (int k = 0; k < 4; ++k) {
      for (int l = k + 1; l < 4; ++l, ++count)
        sum +=
            std::pow(rotation_distance(q.row(mesh.tets(tet, k)).transpose(), q.row(mesh.tets(tet, l)).transpose()), 2);
    }
  }
  return std::sqrt(sum / count);
}

namespace {

/// Moves held vertices of the only body to where `place` puts them, and solves for the rest, statically.
template <class Place> bool move_ends(FemSimulation& simulation, const Place& place, StepStats& stats) {
  StateArchive archive = simulation.archive();
  for (NamedArray& array : archive) {
    if (array.name == "fem/body0/positions") {
      for (std::size_t i = 0; i < array.values.size(); i += 3) {
        Eigen::Map<Vec3> position(array.values.data() + i);
        position = place(static_cast<Eigen::Index>(i / 3), Vec3(position));
      }
    }
    if (array.name == "fem/body0/velocities" || array.name == "fem/body0/angular_velocities")
      std::fill(array.values.begin(), array.values.end(), 0.0);
  }
  EXPECT_TRUE(simulation.restore(archive));
  for (const double end = simulation.time() + 1.0; simulation.time() < end;) {
    const Result<StepStats> stepped = simulation.step(end);
    if (!stepped)
      return false;
    const int cuts = stats.cuts + stepped->cuts;
    stats = *stepped;
    stats.cuts = cuts;
  }
  return true;
}

/// A bar along x whose ends are held, its microrotations free; so light that steps of a second are static.
FemPlan held_bar(ElasticModel model, double poisson_ratio, const Vec3& size, int cells) {
  FemBody body =
      make_body(box_mesh(Vec3(-0.5 * size[0], -0.5, -0.5), size, static_cast<int>(size[0]) * cells, cells, cells),
                model, 1.0, poisson_ratio);
  body.material.density = 1e-6;
  FemPlan plan = plan_of(std::move(body));
  for (const double end : {-0.5 * size[0], 0.5 * size[0]})
    plan.fixed.push_back({"end", 0, vertices_at(*plan.bodies[0].mesh, 0, end), true, false, {}});
  plan.settings.max_time_step = 1.0;
  plan.settings.newton_tolerance = 1e-9;
  plan.settings.max_newton_iterations = 200;
  plan.settings.linear_solver = LinearSolver::cholesky;
  return plan;
}

/// Mean angle between the microrotations of nodes and the polar factor of the mean deformation gradient around them.
double mean_distance_deg(const geometry::TetMesh& mesh, const FemSimulation& simulation) {
  const Points positions = positions_of(simulation);
  const Eigen::MatrixXd q = channel_of(simulation, "microrotation");
  std::vector<Mat3> around(static_cast<std::size_t>(mesh.vertices.rows()), Mat3::Zero());
  for (Eigen::Index tet = 0; tet < mesh.tets.rows(); ++tet) {
    Mat3 rest, now;
    for (int k = 0; k < 3; ++k) {
      rest.col(k) = (mesh.vertices.row(mesh.tets(tet, k + 1)) - mesh.vertices.row(mesh.tets(tet, 0))).transpose();
      now.col(k) = (positions.row(mesh.tets(tet, k + 1)) - positions.row(mesh.tets(tet, 0))).transpose();
    }
    const Mat3 weighted = rest.determinant() * now * rest.inverse();
    for (int k = 0; k < 4; ++k)
      around[static_cast<std::size_t>(mesh.tets(tet, k))] += weighted;
  }
  double sum = 0.0;
  for (std::size_t node = 0; node < around.size(); ++node) {
    const Vec4 matter = quaternion_of(polar_rotation(around[node]));
    sum += rotation_distance(q.row(static_cast<Eigen::Index>(node)).transpose(), matter);
  }
  return sum / static_cast<double>(around.size()) * 180.0 / M_PI;
}

} // namespace

std::vector<Twist> twist_bar(ElasticModel model, double poisson_ratio, double turns) {
  constexpr double STEP = M_PI / 72.0; // of each end
  const FemPlan plan = held_bar(model, poisson_ratio, Vec3(2, 1, 1), 3);
  const geometry::TetMesh& mesh = *plan.bodies[0].mesh;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  std::vector<Twist> rows;
  for (int step = 1; step * 2.0 * STEP <= turns * 2.0 * M_PI + 1e-9; ++step) {
    StepStats stats;
    const bool solved = move_ends(
        *simulation,
        [&](Eigen::Index vertex, const Vec3& position) {
          const double x = mesh.vertices(vertex, 0);
          if (std::abs(x) < 1.0 - 1e-9)
            return position;
          return Vec3(rodrigues(Vec3(x > 0.0 ? STEP : -STEP, 0.0, 0.0)) * position);
        },
        stats);
    if (!solved)
      return rows;
    if (step % 9 == 0)
      rows.push_back({step * 2.0 * STEP / (2.0 * M_PI), mean_distance_deg(mesh, *simulation), stats.elastic_energy});
  }
  return rows;
}

std::vector<double> stretch_bar(ElasticModel model, double poisson_ratio, int cells, double stretch) {
  constexpr double STEP = 0.05; // of the stretch
  const FemPlan plan = held_bar(model, poisson_ratio, Vec3(2, 1, 1), cells);
  const geometry::TetMesh& mesh = *plan.bodies[0].mesh;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  std::vector<double> energies;
  for (int step = 1; step * STEP <= stretch - 1.0 + 1e-9; ++step) {
    StepStats stats;
    const bool solved = move_ends(
        *simulation,
        [&](Eigen::Index vertex, Vec3 position) {
          const double x = mesh.vertices(vertex, 0);
          // The inside is stretched along, so that no element starts far from its end.
          if (std::abs(x) > 1.0 - 1e-9)
            position[0] = x * (1.0 + step * STEP);
          else
            position[0] *= (1.0 + step * STEP) / (1.0 + (step - 1) * STEP);
          return position;
        },
        stats);
    if (!solved || stats.cuts > 0)
      return energies;
    if (step % 2 == 0)
      energies.push_back(stats.elastic_energy);
  }
  return energies;
}

} // namespace wry::fem::test
