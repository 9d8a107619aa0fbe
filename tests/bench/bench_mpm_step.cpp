// Particle-steps per second of complete steps of the material point method: time step control, scatter, grid with a
// floor, gather, material, and sorting as often as it is needed. A heap of sand that slumps: 100,000 particles, 8 per
// cell, Drucker-Prager. CPU time of all threads, so that other programs on the machine count little; `wall` is what a
// clock on the wall says.

#include <cmath>
#include <ctime>
#include <memory>
#include <numbers>
#include <string>

#include <benchmark/benchmark.h>

#include "sim/mpm/mpm_simulation.h"
#include "sim/mpm/seeding.h"

namespace {

using namespace wry;
using namespace wry::mpm;

enum class Matter { isotropic, orthotropic, general };

Material sand(Matter matter) {
  Material material;
  material.name = "sand";
  material.density = 1500.0;
  material.plasticity = Plasticity::drucker_prager;
  material.youngs_modulus = {1e6, 1e6, 1e6};
  material.friction_angle = 35.0 * std::numbers::pi / 180.0;
  if (matter == Matter::orthotropic) {
    material.youngs_modulus = {1e6, 1e6, 5e5};
    material.poisson_ratio.yz = material.poisson_ratio.xz = 0.2;
    material.plastic_scale = {0.9, 0.9, 1.2};
  }
  if (matter == Matter::general) {
    Mat3 map;
    map << 1, 0.1, 0, 0.05, 0.9, 0, 0, 0.1, 1.1;
    material.plastic_map = map;
  }
  return material;
}

std::unique_ptr<MpmSimulation> heap(Matter matter, Precision precision, Transfer transfer, int threads) {
  constexpr double CELL = 0.01;
  SeedSettings seeds;
  seeds.cell = CELL;
  Result<Seeds> filled = fill(
      Vec3(0, 0, 0), Vec3(0.25, 0.2, 0.25), [](const Vec3&) { return true; }, seeds); // 25 x 20 x 25 cells
  MpmPlan plan;
  plan.gravity = Vec3(0, 0, -9.81);
  plan.settings.cell = CELL;
  plan.settings.precision = precision;
  plan.settings.transfer = transfer;
  MpmBody body;
  body.name = "heap";
  body.material = sand(matter);
  body.positions = std::make_shared<const Points>(std::move(filled->positions));
  body.particle_volume = filled->volume;
  body.initial_velocity = Vec3(1.0, 0.5, 0.0);
  plan.bodies.push_back(std::move(body));
  auto floor = std::make_shared<scene::Collider>();
  floor->name = "floor";
  floor->shape = scene::PlaneObstacle{Vec3::Zero(), Vec3::UnitZ()};
  plan.colliders.push_back(floor);
  Result<std::unique_ptr<MpmSimulation>> made = MpmSimulation::create(std::move(plan), threads, native_isa());
  return made ? std::move(*made) : nullptr;
}

void step(benchmark::State& state, Matter matter, Precision precision, Transfer transfer, int threads) {
  const std::unique_ptr<MpmSimulation> simulation = heap(matter, precision, transfer, threads);
  if (!simulation) {
    state.SkipWithError("could not be made");
    return;
  }
  for (int i = 0; i < 20; ++i)
    benchmark::DoNotOptimize(simulation->step(1e9).ok());
  StepStats sum;
  double sorts = 0.0;
  const std::clock_t start = std::clock();
  for (auto _ : state) {
    const Result<StepStats> stats = simulation->step(1e9);
    if (!stats) {
      state.SkipWithError(stats.error().message.c_str());
      return;
    }
    sum.scatter_ms += stats->scatter_ms;
    sum.grid_ms += stats->grid_ms;
    sum.gather_ms += stats->gather_ms;
    sum.sort_ms += stats->sort_ms;
    sorts += stats->sorted ? 1.0 : 0.0;
  }
  const double steps = static_cast<double>(state.iterations());
  const double particles = static_cast<double>(simulation->particle_count());
  const double cpu = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  const double wall_ms = sum.scatter_ms + sum.grid_ms + sum.gather_ms + sum.sort_ms;
  const auto ns = [&](double ms) { return ms * 1e6 / (steps * particles); };
  state.counters["M_per_core_s"] = 1e-6 * particles * steps / cpu;
  state.counters["M_per_wall_s"] = 1e-3 * particles * steps / wall_ms;
  state.counters["scatter_ns"] = ns(sum.scatter_ms);
  state.counters["grid_ns"] = ns(sum.grid_ms);
  state.counters["gather_ns"] = ns(sum.gather_ms);
  state.counters["sort_ns"] = ns(sum.sort_ms);
  state.counters["steps_per_sort"] = sorts > 0.0 ? steps / sorts : steps;
  state.SetLabel(std::string(isa_name(native_isa())));
}

void add_all() {
  const auto add = [](const std::string& name, Matter matter, Precision precision, Transfer transfer) {
    for (const int threads : {1, 2})
      benchmark::RegisterBenchmark((name + "/threads:" + std::to_string(threads)).c_str(),
                                   [=](benchmark::State& state) { step(state, matter, precision, transfer, threads); })
          ->Iterations(60)
          ->Unit(benchmark::kMillisecond);
  };
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    const std::string scalar = precision == Precision::f32 ? "f32" : "f64";
    add(scalar + "/isotropic", Matter::isotropic, precision, Transfer::gradient);
    add(scalar + "/isotropic_mls", Matter::isotropic, precision, Transfer::mls);
    add(scalar + "/orthotropic", Matter::orthotropic, precision, Transfer::gradient);
    add(scalar + "/general_map", Matter::general, precision, Transfer::gradient);
  }
}

} // namespace

int main(int argc, char** argv) {
  add_all();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
