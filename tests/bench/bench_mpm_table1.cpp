// Table 1 of the anisotropic paper again: milliseconds per step, isotropic, anisotropic, and of the sub-particles, for
// its four rows (particle and sub-particle counts as there), one thread, CPU time of the process. CSV on standard
// output. Sub-particles are timed brought up to date in every step, as the paper does, the same turned by Jeffery's
// equation, and as often as accuracy needs. An argument names the instruction set: sse4, avx2, avx512.

#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <unistd.h>

#include "sim/mpm/matter/orientation.h"
#include "sim/mpm/mpm_simulation.h"
#include "sim/mpm/seeding.h"

namespace {

using namespace wry;
using namespace wry::mpm;

struct Row {
  const char* figure;
  Plasticity plasticity;
  Elasticity elasticity;
  PerAxis modulus, ratio, scale;
  double density, cell, particles_per_cell, dt; ///< dt of the paper
  Vec3 low, high;
  int per_particle;
  double paper[3]; ///< ms: isotropic, anisotropic, sub-particles
};

const Row ROWS[] = {{"Fig. 10",
                     Plasticity::drucker_prager,
                     Elasticity::hencky,
                     {1e5, 1e5, 1e5},
                     {.4, .4, .4},
                     {1, 1, .75},
                     1000,
                     .01,
                     5,
                     2e-4,
                     {.45, .45, .02},
                     {.55, .55, .22},
                     10,
                     {83, 97, 136}},
                    {"Fig. 1",
                     Plasticity::shear,
                     Elasticity::linear,
                     {1e5, 1e5, 5e4},
                     {.1, .1, .4},
                     {.8, .8, 1.4},
                     80,
                     .01,
                     1.25,
                     2e-4,
                     {.4, .3, .6},
                     {.6, .7, .7},
                     10,
                     {83, 102, 137}},
                    {"Fig. 8",
                     Plasticity::drucker_prager,
                     Elasticity::hencky,
                     {5e5, 5e5, 5e4},
                     {.4, .4, .1},
                     {.8, .8, 1.4},
                     1000,
                     .01,
                     2.08,
                     1e-4,
                     {.3, .05, .02},
                     {.7, .25, .32},
                     4,
                     {242, 325, 270}},
                    {"Fig. 2",
                     Plasticity::drucker_prager,
                     Elasticity::hencky,
                     {5e5, 5e5, 5e4},
                     {.4, .4, .1},
                     {.8, .8, 1.4},
                     1800,
                     .01,
                     2,
                     1.5e-4,
                     {.3, .05, .02},
                     {.7, .5, .17},
                     4,
                     {127, 164, 270}}};

/// The authors' own code, built with g++ 12 and timed on one core of a server with AVX-512.
constexpr double AUTHORS_STEP_US = 30.0, AUTHORS_GRAIN_US = 9.3;

enum class Kind { isotropic, anisotropic, grains_every_step, grains_as_needed, grains_by_flow };

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

MpmPlan plan_of(const Row& row, Kind kind, Precision precision) {
  MpmBody body;
  body.name = "matter";
  SeedSettings seeds;
  seeds.cell = row.cell;
  seeds.particles_per_cell = row.particles_per_cell;
  seeds.sampling = Sampling::jittered;
  const auto filled = fill(
      row.low, row.high, [](const Vec3&) { return true; }, seeds);
  body.positions = std::make_shared<const Points>(filled->positions);
  body.particle_volume = filled->volume;
  body.material.density = row.density;
  body.material.plasticity = row.plasticity;
  body.material.elasticity = row.elasticity;
  if (kind == Kind::isotropic) {
    const double mean = std::cbrt(row.modulus[0] * row.modulus[1] * row.modulus[2]);
    body.material.youngs_modulus = {mean, mean, mean};
  } else {
    body.material.youngs_modulus = row.modulus;
    body.material.poisson_ratio = {row.ratio[0], row.ratio[1], row.ratio[2]};
    body.material.plastic_scale = row.scale;
  }
  if (kind == Kind::grains_every_step || kind == Kind::grains_as_needed || kind == Kind::grains_by_flow) {
    body.sub_particles.emplace();
    body.sub_particles->name = "grains";
    body.sub_particles->per_particle = row.per_particle;
    if (kind != Kind::grains_as_needed)
      body.sub_particles->travel = 0.0;
    if (kind == Kind::grains_by_flow)
      body.sub_particles->jeffery = jeffery_shape(5.0);
  }
  MpmPlan plan;
  plan.bodies.push_back(std::move(body));
  plan.gravity = Vec3(0, 0, -9.81);
  auto floor = std::make_shared<scene::Collider>();
  floor->shape = scene::PlaneObstacle{Vec3::Zero(), Vec3::UnitZ()};
  plan.colliders.push_back(floor);
  plan.settings.cell = row.cell;
  plan.settings.precision = precision;
  plan.settings.time_step = row.dt;
  return plan;
}

struct Cost {
  double ms = 0.0;
  std::size_t particles = 0;
};

Cost per_step(const Row& row, Kind kind, Precision precision, Isa isa) {
  auto simulation = MpmSimulation::create(plan_of(row, kind, precision), 1, isa);
  if (!simulation)
    return {};
  constexpr int WARM = 40, STEPS = 60;
  double start = 0.0;
  for (int i = 0; i < WARM + STEPS; ++i) {
    if (i == WARM)
      start = cpu_ms();
    if (!(*simulation)->step(1e3))
      return {};
  }
  return {(cpu_ms() - start) / STEPS, (*simulation)->particle_count()};
}

} // namespace

int main(int count, char** words) {
  const Result<Isa> isa = parse_isa(count > 1 ? words[1] : "auto");
  if (!isa) {
    fmt::print(stderr, "{}\n", isa.error().message);
    return 2;
  }
  char host[256] = "?";
  gethostname(host, sizeof host - 1);
  fmt::print("machine,isa,precision,figure,particles,grains,isotropic_ms,anisotropic_ms,ratio,grains_ms,"
             "grains_us_each,grains_as_needed_ms,grains_turned_by_flow_us_each,paper_isotropic_ms,paper_anisotropic_ms,"
             "paper_grains_ms,"
             "authors_code_step_ms,authors_code_grains_ms\n");
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    for (const Row& row : ROWS) {
      const Cost isotropic = per_step(row, Kind::isotropic, precision, *isa);
      const Cost anisotropic = per_step(row, Kind::anisotropic, precision, *isa);
      const Cost every = per_step(row, Kind::grains_every_step, precision, *isa);
      const Cost needed = per_step(row, Kind::grains_as_needed, precision, *isa);
      const Cost by_flow = per_step(row, Kind::grains_by_flow, precision, *isa);
      const auto grains = anisotropic.particles * static_cast<std::size_t>(row.per_particle);
      const double extra = every.ms - anisotropic.ms;
      fmt::print("{},{},{},{},{},{},{:.3f},{:.3f},{:.3f},{:.3f},{:.4f},{:.3f},{:.4f},{},{},{},{:.0f},{:.0f}\n", host,
                 isa_name(*isa), precision == Precision::f32 ? "f32" : "f64", row.figure, anisotropic.particles, grains,
                 isotropic.ms, anisotropic.ms, anisotropic.ms / isotropic.ms, extra,
                 1e3 * extra / static_cast<double>(grains), needed.ms - anisotropic.ms,
                 1e3 * (by_flow.ms - anisotropic.ms) / static_cast<double>(grains), row.paper[0], row.paper[1],
                 row.paper[2], AUTHORS_STEP_US * 1e-3 * static_cast<double>(anisotropic.particles),
                 AUTHORS_GRAIN_US * 1e-3 * static_cast<double>(grains));
      std::fflush(stdout);
    }
  }
  return 0;
}
