// Error of sub-particles against their run time: how far apart grains are at the end when they are brought up to date
// every `travel` cells, from where they are when it happens in every step. The matter is the same, bit for bit. Of
// grains that the matter carries all the time (one that flies, even for an update, goes its own way). CSV on standard
// output. An argument names the instruction set: sse4, avx2, avx512.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "sim/mpm/mpm_simulation.h"
#include "sim/mpm/seeding.h"

namespace {

using namespace wry;
using namespace wry::mpm;

constexpr double CELL = 0.01, END = 0.25, FPS = 48.0;

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

/// A cube of cards that collapses on a floor.
MpmPlan cards(double travel) {
  MpmBody body;
  body.name = "cards";
  SeedSettings seeds;
  seeds.cell = CELL;
  seeds.particles_per_cell = 4;
  const auto filled = fill(
      Vec3(-.06, -.06, .01), Vec3(.06, .06, .13), [](const Vec3&) { return true; }, seeds);
  body.positions = std::make_shared<const Points>(filled->positions);
  body.particle_volume = filled->volume;
  body.material.density = 1000;
  body.material.elasticity = Elasticity::hencky;
  body.material.plasticity = Plasticity::drucker_prager;
  body.material.youngs_modulus = {5e4, 5e4, 1e5};
  body.material.poisson_ratio = {.2, .2, 0};
  body.material.plastic_scale = {1.1, 1.1, .8};
  if (travel >= 0.0) {
    body.sub_particles.emplace();
    body.sub_particles->name = "grains";
    body.sub_particles->travel = travel;
  }
  MpmPlan plan;
  plan.bodies.push_back(std::move(body));
  plan.gravity = Vec3(0, 0, -9.81);
  auto floor = std::make_shared<scene::Collider>();
  floor->shape = scene::PlaneObstacle{Vec3::Zero(), Vec3::UnitZ()};
  plan.colliders.push_back(floor);
  plan.settings.cell = CELL;
  return plan;
}

struct Outcome {
  double ms = 0.0;
  int steps = 0;
  std::vector<double> positions;
  std::vector<bool> always_carried;
};

void look(const Frame& frame, Outcome& outcome) {
  const FrameBody& grains = frame.bodies.back();
  outcome.positions = find_channel(grains, "position")->values;
  const std::vector<double>& phase = find_channel(grains, "phase")->values;
  outcome.always_carried.resize(phase.size(), true);
  for (std::size_t i = 0; i < phase.size(); ++i) {
    if (phase[i] != 0.0)
      outcome.always_carried[i] = false;
  }
}

Outcome run(double travel, Isa isa) {
  Outcome outcome;
  auto simulation = MpmSimulation::create(cards(travel), 1, isa);
  if (!simulation)
    return outcome;
  for (int frame = 1; frame <= static_cast<int>(END * FPS); ++frame) {
    const double start = cpu_ms();
    while ((*simulation)->time() < frame / FPS * (1.0 - 1e-12)) {
      if (!(*simulation)->step(frame / FPS))
        return outcome;
      ++outcome.steps;
    }
    outcome.ms += cpu_ms() - start;
    if (travel >= 0.0)
      look((*simulation)->snapshot(frame), outcome);
  }
  return outcome;
}

double quantile(std::vector<double> values, double share) {
  if (values.empty())
    return 0.0;
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

} // namespace

int main(int count, char** words) {
  const Result<Isa> isa = parse_isa(count > 1 ? words[1] : "auto");
  if (!isa) {
    fmt::print(stderr, "{}\n", isa.error().message);
    return 2;
  }
  const Outcome bare = run(-1.0, *isa), reference = run(0.0, *isa);
  fmt::print("travel_cells,steps,grains,grains_ms,us_per_grain_and_step,median_error_cells,error_of_99_percent_cells,"
             "carried_in_both\n");
  for (const double travel : {0.0, 0.05, 0.1, 0.25, 0.5}) {
    const Outcome outcome = run(travel, *isa);
    std::vector<double> errors;
    for (std::size_t i = 0; i < reference.always_carried.size(); ++i) {
      if (!reference.always_carried[i] || !outcome.always_carried[i])
        continue;
      double squared = 0.0;
      for (std::size_t k = 0; k < 3; ++k)
        squared += std::pow(outcome.positions[3 * i + k] - reference.positions[3 * i + k], 2);
      errors.push_back(std::sqrt(squared) / CELL);
    }
    const double grains = static_cast<double>(reference.always_carried.size());
    const double ms = outcome.ms - bare.ms;
    fmt::print("{},{},{},{:.1f},{:.4f},{:.5f},{:.5f},{}\n", travel, outcome.steps, grains, ms,
               1e3 * ms / (grains * outcome.steps), quantile(errors, 0.5), quantile(errors, 0.99), errors.size());
    std::fflush(stdout);
  }
  return 0;
}
