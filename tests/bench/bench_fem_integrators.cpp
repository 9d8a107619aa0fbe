// Error against run time of the integrators, as CSV: a micropolar bar with rotary inertia, one end turned and let go,
// against SDIRK2 with steps eight times shorter than the shortest of the table.
// Usage: bench_fem_integrators > tests/evidence/integrators.csv

#include <cmath>
#include <cstdio>
#include <ctime>

#include "sim/fem/fem_simulation.h"

namespace {

using namespace wry;
using namespace wry::fem;

constexpr double END = 0.4;   // [s]
constexpr double DRIVE = 0.1; // [s], how long the end is turned

std::shared_ptr<const geometry::TetMesh> bar(int nx, int ny, int nz, const Vec3& size) {
  auto mesh = std::make_shared<geometry::TetMesh>();
  const auto number = [&](int i, int j, int k) { return (i * (ny + 1) + j) * (nz + 1) + k; };
  mesh->vertices.resize((nx + 1) * (ny + 1) * (nz + 1), 3);
  for (int i = 0; i <= nx; ++i) {
    for (int j = 0; j <= ny; ++j) {
      for (int k = 0; k <= nz; ++k)
        mesh->vertices.row(number(i, j, k)) << size[0] * i / nx, size[1] * j / ny, size[2] * k / nz;
    }
  }
  constexpr int ORDERS[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {1, 0, 2}, {2, 1, 0}};
  mesh->tets.resize(6 * nx * ny * nz, 4);
  int tet = 0;
  for (int i = 0; i < nx; ++i) {
    for (int j = 0; j < ny; ++j) {
      for (int k = 0; k < nz; ++k) {
        for (int o = 0; o < 6; ++o, ++tet) {
          int at[3] = {i, j, k};
          mesh->tets(tet, 0) = number(i, j, k);
          for (int step = 0; step < 3; ++step) {
            ++at[ORDERS[o][step]];
            mesh->tets(tet, step + 1) = number(at[0], at[1], at[2]);
          }
          if (o >= 3)
            std::swap(mesh->tets(tet, 2), mesh->tets(tet, 3));
        }
      }
    }
  }
  return mesh;
}

FemPlan plan_with(Integrator integrator, int steps) {
  FemPlan plan;
  FemBody body;
  body.name = "bar";
  body.mesh = bar(8, 2, 2, Vec3(0.4, 0.05, 0.05));
  body.material.name = "bar";
  body.material.model = ElasticModel::micropolar;
  body.material.youngs_modulus = 2e4;
  body.material.length_scale = 0.05;
  body.material.curvature = CurvatureModel::isotropic;
  body.material.rotary_inertia = 1.0;
  plan.gravity.setZero();
  FixedNodes fixed;
  DrivenNodes drive;
  for (int i = 0; i < body.mesh->vertices.rows(); ++i) {
    if (body.mesh->vertices(i, 0) < 1e-9)
      fixed.nodes.push_back(i);
    if (body.mesh->vertices(i, 0) > 0.4 - 1e-9)
      drive.nodes.push_back(i);
  }
  drive.motion = scene::Motion::along_keys(
                     {{{0.0, Vec3::Zero(), Vec3::UnitX(), 0.0}, {DRIVE, Vec3(0, 0.05, 0), Vec3::UnitX(), 60.0}},
                      Vec3(0, 0.025, 0.025),
                      scene::Ease::smooth})
                     .value();
  drive.until = DRIVE;
  plan.bodies.push_back(std::move(body));
  plan.fixed.push_back(std::move(fixed));
  plan.driven.push_back(std::move(drive));
  plan.settings.integrator = integrator;
  plan.settings.max_time_step = END / steps;
  plan.settings.newton_tolerance = 1e-11;
  return plan;
}

struct Outcome {
  Eigen::VectorXd positions, rotations;
  double seconds = 0.0;
  int newton = 0, steps = 0;
};

Outcome run(Integrator integrator, int steps) {
  const std::unique_ptr<FemSimulation> simulation =
      FemSimulation::create(plan_with(integrator, steps), 1, native_isa()).value();
  Outcome outcome;
  const std::clock_t start = std::clock();
  while (simulation->time() < END) {
    outcome.newton += simulation->step(END).value().newton_iterations;
    ++outcome.steps;
  }
  outcome.seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  for (const NamedArray& array : simulation->archive()) {
    const Eigen::Map<const Eigen::VectorXd> values(array.values.data(), static_cast<Eigen::Index>(array.values.size()));
    if (array.name == "fem/body0/positions")
      outcome.positions = values;
    if (array.name == "fem/body0/rotations")
      outcome.rotations = values;
  }
  return outcome;
}

} // namespace

int main() {
  struct Method {
    const char* name;
    Integrator integrator;
  };
  constexpr Method METHODS[] = {
      {"backward-euler", Integrator::backward_euler}, {"bdf2", Integrator::bdf2}, {"sdirk2", Integrator::sdirk2}};
  constexpr int STEPS[] = {20, 40, 80, 160, 320};
  const Outcome reference = run(Integrator::sdirk2, 8 * 320);
  std::printf("integrator,steps,dt_s,cpu_s,newton_per_step,position_error_m,rotation_error,order\n");
  for (const Method& method : METHODS) {
    double before = 0.0;
    for (const int steps : STEPS) {
      const Outcome outcome = run(method.integrator, steps);
      const double nodes = static_cast<double>(reference.positions.size()) / 3.0;
      const double error = (outcome.positions - reference.positions).norm() / std::sqrt(nodes);
      const double turned = 2.0 * (outcome.rotations - reference.rotations).norm() / std::sqrt(nodes);
      std::printf("%s,%d,%.6g,%.4g,%.3g,%.4g,%.4g,%.3g\n", method.name, steps, END / steps, outcome.seconds,
                  static_cast<double>(outcome.newton) / outcome.steps, error, turned,
                  before > 0.0 ? std::log2(before / error) : 0.0);
      before = error;
    }
  }
  return 0;
}
