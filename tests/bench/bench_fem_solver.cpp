// Milliseconds per Newton iteration of twisted beams, split into evaluation, assembly and solve, as CSV.
// Usage: bench_fem_solver [scene-filter [threads [steps]]]

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

#include "sim/fem/fem_simulation.h"

namespace {

using namespace wry;
using namespace wry::fem;

std::shared_ptr<const geometry::TetMesh> kuhn_beam(const Vec3& size, int nx, int ny, int nz) {
  std::shared_ptr<geometry::TetMesh> mesh = std::make_shared<geometry::TetMesh>();
  const auto number = [&](const int* at) { return (at[0] * (ny + 1) + at[1]) * (nz + 1) + at[2]; };
  mesh->vertices.resize((nx + 1) * (ny + 1) * (nz + 1), 3);
  mesh->tets.resize(6 * nx * ny * nz, 4);
  constexpr int ORDERS[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {1, 0, 2}, {2, 1, 0}};
  int tet = 0;
  for (int i = 0; i <= nx; ++i) {
    for (int j = 0; j <= ny; ++j) {
      for (int k = 0; k <= nz; ++k) {
        const int at[3] = {i, j, k};
        mesh->vertices.row(number(at)) << size[0] * i / nx, size[1] * (static_cast<double>(j) / ny - 0.5),
            size[2] * (static_cast<double>(k) / nz - 0.5);
        if (i == nx || j == ny || k == nz)
          continue;
        for (int o = 0; o < 6; ++o, ++tet) {
          int corner[3] = {i, j, k};
          mesh->tets(tet, 0) = number(corner);
          for (int step = 0; step < 3; ++step) {
            ++corner[ORDERS[o][step]];
            mesh->tets(tet, step + 1) = number(corner);
          }
          if (o >= 3) // odd permutations are mirrored
            std::swap(mesh->tets(tet, 2), mesh->tets(tet, 3));
        }
      }
    }
  }
  return mesh;
}

struct Scene {
  const char* name;
  ElasticModel model;
  CurvatureModel curvature;
  double youngs_modulus;
  Vec3 size;
  int cells[3];
  double twist; ///< radians from end to end at the start
  LinearSolver solver;
};

FemPlan make_plan(const Scene& scene) {
  FemPlan plan;
  FemBody body;
  body.name = "beam";
  body.mesh = kuhn_beam(scene.size, scene.cells[0], scene.cells[1], scene.cells[2]);
  body.material.model = scene.model;
  body.material.youngs_modulus = scene.youngs_modulus;
  body.material.curvature = scene.curvature;
  body.material.length_scale = scene.curvature == CurvatureModel::none ? 0.0 : 0.05;
  body.material.curvature_stiffness << 1, 1, 1, 1, 20, 1, 1, 1, 1;
  for (int end = 0; end < 2; ++end) {
    FixedNodes fixed;
    for (Eigen::Index i = 0; i < body.mesh->vertices.rows(); ++i) {
      if (std::abs(body.mesh->vertices(i, 0) - end * scene.size[0]) < 1e-9)
        fixed.nodes.push_back(static_cast<std::int32_t>(i));
    }
    fixed.hold_microrotations = false;
    plan.fixed.push_back(std::move(fixed));
  }
  plan.bodies.push_back(std::move(body));
  plan.settings.linear_solver = scene.solver;
  return plan;
}

/// Sets the cross-sections turning, and those of classic bodies turned: held ends stay as they are. Microrotations of a
/// turned start would not fit, so micropolar bodies get the speed only.
void twist(StateArchive& archive, const Points& rest, double length, double angle) {
  const bool micropolar = std::any_of(archive.begin(), archive.end(),
                                      [](const NamedArray& array) { return array.name == "fem/body0/rotations"; });
  for (NamedArray& array : archive) {
    for (Eigen::Index i = 0; micropolar && array.name == "fem/body0/velocities" && i < rest.rows(); ++i) {
      const double turn = 4.0 * angle * std::sin(3.14159265358979 * rest(i, 0) / length);
      array.values[3 * i + 1] = -turn * rest(i, 2);
      array.values[3 * i + 2] = turn * rest(i, 1);
    }
    if (micropolar)
      continue;
    if (array.name != "fem/body0/positions")
      continue;
    for (std::size_t i = 0; i < array.values.size(); i += 3) {
      const double turn = angle * array.values[i] / length;
      const double y = array.values[i + 1];
      const double z = array.values[i + 2];
      array.values[i + 1] = std::cos(turn) * y - std::sin(turn) * z;
      array.values[i + 2] = std::sin(turn) * y + std::cos(turn) * z;
    }
  }
}

int run(const Scene& scene, int threads, int steps, const char* machine) {
  const FemPlan plan = make_plan(scene);
  Result<std::unique_ptr<FemSimulation>> made = FemSimulation::create(plan, threads, native_isa());
  if (!made) {
    std::fprintf(stderr, "%s: %s\n", scene.name, made.error().message.c_str());
    return 1;
  }
  FemSimulation& simulation = **made;
  StateArchive archive = simulation.archive();
  twist(archive, plan.bodies[0].mesh->vertices, scene.size[0], scene.twist);
  if (Status status = simulation.restore(archive); !status)
    return 1;
  StepStats sum;
  const std::clock_t start = std::clock();
  for (int i = 0; i < steps; ++i) {
    const Result<StepStats> stats = simulation.step(1000.0);
    if (!stats) {
      std::fprintf(stderr, "%s: %s\n", scene.name, stats.error().message.c_str());
      return 1;
    }
    sum.newton_iterations += stats->newton_iterations;
    sum.linear_iterations += stats->linear_iterations;
    sum.line_search_halvings += stats->line_search_halvings;
    sum.projected_elements += stats->projected_elements;
    sum.cuts += stats->cuts;
    sum.evaluate_ms += stats->evaluate_ms;
    sum.assemble_ms += stats->assemble_ms;
    sum.solve_ms += stats->solve_ms;
    sum.total_ms += stats->total_ms;
  }
  const double cpu_ms = 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  const double n = std::max(1, sum.newton_iterations);
  std::printf("%s,%s,%d,%ld,%zu,%d,%d,%.1f,%d,%d,%d,%.3f,%.3f,%.3f,%.3f,%.3f,%.2f\n", machine, scene.name, threads,
              static_cast<long>(plan.bodies[0].mesh->tets.rows()), simulation.dof_count(), steps, sum.newton_iterations,
              sum.linear_iterations / n, sum.line_search_halvings, sum.projected_elements, sum.cuts,
              sum.evaluate_ms / n, sum.assemble_ms / n, sum.solve_ms / n,
              (sum.evaluate_ms + sum.assemble_ms + sum.solve_ms) / n, cpu_ms / n, sum.total_ms / steps);
  std::fflush(stdout);
  return 0;
}

} // namespace

int main(int argc, char** argv) {
  const std::string filter = argc > 1 ? argv[1] : "";
  const int only_threads = argc > 2 ? std::atoi(argv[2]) : 0;
  const int steps = argc > 3 ? std::atoi(argv[3]) : 20;
  const Vec3 beam(1.0, 0.1, 0.1);
  const Vec3 bar(0.6, 0.05, 0.05);
  const Vec3 sheet(1.0, 1.0, 0.02);
  constexpr ElasticModel NH = ElasticModel::neo_hookean;
  constexpr ElasticModel MP = ElasticModel::micropolar;
  constexpr CurvatureModel NONE = CurvatureModel::none;
  constexpr CurvatureModel ORTHO = CurvatureModel::orthotropic;
  const Scene scenes[] = {
      {"beam_nh_pcg", NH, NONE, 1e5, beam, {80, 8, 8}, 3.14, LinearSolver::pcg},
      {"beam_nh_cholesky", NH, NONE, 1e5, beam, {80, 8, 8}, 3.14, LinearSolver::cholesky},
      {"beam_nh_stale", NH, NONE, 1e5, beam, {80, 8, 8}, 3.14, LinearSolver::stale_cholesky},
      {"bar_mp_pcg", MP, NONE, 1e4, bar, {60, 5, 5}, 3.14, LinearSolver::pcg},
      {"bar_mp_cholesky", MP, NONE, 1e4, bar, {60, 5, 5}, 3.14, LinearSolver::cholesky},
      {"bar_mp_stale", MP, NONE, 1e4, bar, {60, 5, 5}, 3.14, LinearSolver::stale_cholesky},
      {"bar_mp_curvature_pcg", MP, ORTHO, 1e4, bar, {60, 5, 5}, 3.14, LinearSolver::pcg},
      {"bar_mp_curvature_cholesky", MP, ORTHO, 1e4, bar, {60, 5, 5}, 3.14, LinearSolver::cholesky},
      {"bar_mp_curvature_stale", MP, ORTHO, 1e4, bar, {60, 5, 5}, 3.14, LinearSolver::stale_cholesky},
      {"bar_mp_stiff_pcg", MP, NONE, 1e6, bar, {60, 5, 5}, 3.14, LinearSolver::pcg},
      {"bar_mp_stiff_cholesky", MP, NONE, 1e6, bar, {60, 5, 5}, 3.14, LinearSolver::cholesky},
      {"bar_mp_stiff_stale", MP, NONE, 1e6, bar, {60, 5, 5}, 3.14, LinearSolver::stale_cholesky},
      {"sheet_mp_pcg", MP, NONE, 1e5, sheet, {60, 60, 2}, 0.5, LinearSolver::pcg},
      {"sheet_mp_cholesky", MP, NONE, 1e5, sheet, {60, 60, 2}, 0.5, LinearSolver::cholesky},
      {"sheet_mp_stale", MP, NONE, 1e5, sheet, {60, 60, 2}, 0.5, LinearSolver::stale_cholesky},
  };
  char machine[64] = {};
  gethostname(machine, sizeof machine - 1);
  std::printf("machine,scene,threads,tets,dofs,steps,newton,linear_per_newton,halvings,projected,cuts,evaluate_ms,"
              "assemble_ms,solve_ms,newton_ms,newton_cpu_ms,step_ms\n");
  int failures = 0;
  for (const Scene& scene : scenes) {
    if (std::string(scene.name).find(filter) == std::string::npos)
      continue;
    for (const int threads : only_threads == 0 ? std::vector<int>{1, 2} : std::vector<int>{only_threads})
      failures += run(scene, threads, steps, machine);
  }
  return failures == 0 ? 0 : 1;
}
