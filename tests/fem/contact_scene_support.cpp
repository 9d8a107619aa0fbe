#include "tests/fem/contact_scene_support.h"

#include <numeric>

#include <Eigen/Geometry>

#include "sim/contact/crossings.h"
#include "sim/geometry/tet_mesh.h"
#include "tests/extreme_table.h"

namespace wry::fem::test {

FemBody box_body(const std::string& name, const Vec3& corner, const Vec3& size, const Eigen::Vector3i& cells,
                 double youngs_modulus) {
  FemBody body =
      make_body(box_mesh(corner, size, cells[0], cells[1], cells[2]), ElasticModel::neo_hookean, youngs_modulus, 0.3);
  body.name = name;
  return body;
}

FemBody tet_body(const std::string& name, const Eigen::Matrix<double, 4, 3>& corners, double youngs_modulus) {
  std::shared_ptr<geometry::TetMesh> mesh = std::make_shared<geometry::TetMesh>();
  mesh->vertices = corners;
  mesh->tets.resize(1, 4);
  mesh->tets << 0, 1, 2, 3;
  const Vec3 a = corners.row(1) - corners.row(0);
  const Vec3 b = corners.row(2) - corners.row(0);
  const Vec3 c = corners.row(3) - corners.row(0);
  if (a.cross(b).dot(c) < 0.0)
    std::swap(mesh->tets(0, 2), mesh->tets(0, 3));
  FemBody body = make_body(mesh, ElasticModel::neo_hookean, youngs_modulus, 0.3);
  body.name = name;
  return body;
}

std::string find_intersection(const FemPlan& plan, const FemSimulation& simulation) {
  contact::Surface surface;
  Points all(0, 3);
  for (std::size_t i = 0; i < plan.bodies.size(); ++i) {
    const Triangles triangles = geometry::boundary_triangles(*plan.bodies[i].mesh);
    std::vector<contact::Surface::Triangle> rows;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
      rows.push_back({triangles(t, 0), triangles(t, 1), triangles(t, 2)});
    const Points positions = positions_of(simulation, static_cast<int>(i));
    surface.add_part(static_cast<int>(positions.rows()), rows);
    for (std::size_t j = 0; j <= i; ++j)
      surface.let_meet(static_cast<int>(i), static_cast<int>(j));
    const Eigen::Index before = all.rows();
    all.conservativeResize(before + positions.rows(), 3);
    all.bottomRows(positions.rows()) = positions;
  }
  const std::vector<contact::Crossing> crossings = contact::find_crossings(surface, all, Threads(1), 1);
  if (crossings.empty())
    return {};
  return fmt::format("edge {} {} and triangle {} {} {}", crossings[0].edge[0], crossings[0].edge[1],
                     crossings[0].triangle[0], crossings[0].triangle[1], crossings[0].triangle[2]);
}

namespace {

Outcome run_until_crossing(const FemPlan& plan, double end) {
  Outcome outcome;
  Result<std::unique_ptr<FemSimulation>> simulation = FemSimulation::create(plan, 1, native_isa());
  if (!simulation) {
    outcome.error = simulation.error().message;
    return outcome;
  }
  while ((*simulation)->time() < end) {
    const Result<StepStats> stats = (*simulation)->step(end);
    outcome.intersection = find_intersection(plan, **simulation);
    outcome.reached = (*simulation)->time();
    if (!stats) {
      outcome.error = stats.error().message;
      return outcome;
    }
    ++outcome.steps;
    outcome.iterations += stats->newton_iterations;
    outcome.cuts += stats->cuts;
    outcome.worst_residual = std::max(outcome.worst_residual, stats->residual);
    outcome.contacts = std::max(outcome.contacts, stats->contacts);
    outcome.least_gap = std::min(outcome.least_gap, stats->least_distance);
    if (!outcome.intersection.empty())
      return outcome;
  }
  return outcome;
}

} // namespace

Outcome run_and_check(const FemPlan& plan, double end, const std::string& name) {
  const Outcome outcome = run_until_crossing(plan, end);
  if (name.empty())
    return outcome;
  const char* word = !outcome.intersection.empty() ? "INTERSECTS"
                     : !outcome.error.empty()      ? "refuses"
                     : outcome.cuts > 0            ? "shorter steps"
                                                   : "holds";
  wry::test::note_extreme(
      "contact", name, {word, outcome.steps, outcome.iterations, outcome.cuts, outcome.worst_residual, outcome.error});
  return outcome;
}

void fix_body(FemPlan& plan, int body) {
  FixedNodes fixed;
  fixed.name = "fixed";
  fixed.body = body;
  fixed.nodes.resize(static_cast<std::size_t>(plan.bodies[static_cast<std::size_t>(body)].mesh->vertices.rows()));
  std::iota(fixed.nodes.begin(), fixed.nodes.end(), 0);
  plan.fixed.push_back(fixed);
}

namespace {

struct Motion {
  Vec3 momentum = Vec3::Zero();
  double mass = 0.0;
};

Motion motion_of(const FemPlan& plan, const FemSimulation& simulation, int body) {
  Motion motion;
  const geometry::TetMesh& mesh = *plan.bodies[static_cast<std::size_t>(body)].mesh;
  const double density = plan.bodies[static_cast<std::size_t>(body)].material.density;
  const Eigen::MatrixXd velocities = channel_of(simulation, "velocity", body);
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
    const Vec3 a = mesh.vertices.row(mesh.tets(t, 1)) - mesh.vertices.row(mesh.tets(t, 0));
    const Vec3 b = mesh.vertices.row(mesh.tets(t, 2)) - mesh.vertices.row(mesh.tets(t, 0));
    const Vec3 c = mesh.vertices.row(mesh.tets(t, 3)) - mesh.vertices.row(mesh.tets(t, 0));
    const double share = density * a.cross(b).dot(c) / 24.0;
    for (int k = 0; k < 4; ++k) {
      motion.momentum += share * velocities.row(mesh.tets(t, k)).transpose();
      motion.mass += share;
    }
  }
  return motion;
}

} // namespace

Vec3 momentum_of(const FemPlan& plan, const FemSimulation& simulation) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < plan.bodies.size(); ++i)
    sum += motion_of(plan, simulation, static_cast<int>(i)).momentum;
  return sum;
}

Vec3 velocity_of(const FemPlan& plan, const FemSimulation& simulation, int body) {
  const Motion motion = motion_of(plan, simulation, body);
  return motion.momentum / motion.mass;
}

} // namespace wry::fem::test
