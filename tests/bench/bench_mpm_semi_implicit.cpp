// Error against run time of explicit and semi-implicit steps, as CSV: a free bar that swings along its length, against
// the closed form, over one period. Its fibres are ten thousand times stiffer than what is between them and lie across
// the bar, where they bound explicit steps and do nothing else; or along it, where what swings is what bounds the step.
// Usage: bench_mpm_semi_implicit > tests/evidence/mpm_semi_implicit.csv

#include <cmath>
#include <cstdio>
#include <ctime>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include "sim/mpm/mpm_simulation.h"
#include "sim/mpm/seeding.h"

namespace {

using namespace wry;
using namespace wry::mpm;

constexpr double LENGTH = 1.0;     // [m]
constexpr int CELLS = 16;          // along the bar
constexpr double MODULUS = 1e5;    // [Pa], across the fibres
constexpr double RATIO = 1e4;      // of the fibres' modulus to that
constexpr double DENSITY = 1000.0; // [kg/m^3]
constexpr double SPEED = 1e-3;     // [m/s], of the ends at the start
constexpr int SAMPLES = 8;         // of a period

struct Case {
  const char* name;
  Vec3 fibre;
};

double mode(double x) {
  return std::cos(std::numbers::pi * x / LENGTH);
}

MpmPlan bar(const Case& which) {
  MpmPlan plan;
  plan.gravity = Vec3::Zero();
  plan.settings.cell = LENGTH / CELLS;
  plan.settings.precision = Precision::f64;
  const double offset = 0.5 * plan.settings.cell; // ends between nodes, so that no face is favoured
  SeedSettings seeds;
  seeds.cell = plan.settings.cell;
  Result<Seeds> filled = fill(
      Vec3::Constant(offset), Vec3(LENGTH + offset, 5 * offset, 5 * offset), [](const Vec3&) { return true; }, seeds);
  MpmBody body;
  body.name = "bar";
  body.material.name = "fibres";
  body.material.density = DENSITY;
  body.material.youngs_modulus = {MODULUS, MODULUS, RATIO * MODULUS};
  body.material.poisson_ratio = {0.0, 0.0, 0.0};
  body.material.shear_modulus = Material::Shear{0.5 * MODULUS, 0.5 * MODULUS, 0.5 * MODULUS};
  body.frame = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), which.fibre).toRotationMatrix();
  body.positions = std::make_shared<const Points>(std::move(filled->positions));
  body.particle_volume = filled->volume;
  body.velocity_field = [offset](const Vec3& x) { return Vec3(SPEED * mode(x.x() - offset), 0, 0); };
  plan.bodies.push_back(std::move(body));
  return plan;
}

/// Of the first mode: displacement [m].
double amplitude(const MpmSimulation& simulation, const Points& start) {
  const Frame frame = simulation.snapshot(0);
  const wry::Channel* now = find_channel(frame.bodies.front(), "position");
  double moved = 0.0, scale = 0.0;
  for (Eigen::Index i = 0; i < start.rows(); ++i) {
    const double shape = mode(start(i, 0) - 0.5 / CELLS);
    moved += shape * (now->values[static_cast<std::size_t>(3 * i)] - start(i, 0));
    scale += shape * shape;
  }
  return moved / scale;
}

struct Outcome {
  double seconds = 0.0; ///< of the processor
  double error = 0.0;   ///< root mean square over the period, over the amplitude
  double energy = 0.0;  ///< that is left at its end, over that at the start
  int steps = 0, iterations = 0;
  bool ok = true;
};

Outcome run(MpmPlan plan) {
  Outcome outcome;
  const Points start = *plan.bodies[0].positions;
  const double modulus = plan.bodies[0].frame.col(2).x() > 0.5 ? RATIO * MODULUS : MODULUS;
  const double frequency = std::numbers::pi / LENGTH * std::sqrt(modulus / DENSITY);
  Result<std::unique_ptr<MpmSimulation>> made = MpmSimulation::create(std::move(plan), 1, native_isa());
  if (!made)
    return outcome;
  MpmSimulation& simulation = **made;
  const double put_in = simulation.totals().kinetic_energy;
  double sum = 0.0;
  for (int sample = 1; sample <= SAMPLES && outcome.ok; ++sample) {
    const double time = 2.0 * std::numbers::pi / frequency * sample / SAMPLES;
    const std::clock_t clock = std::clock();
    while (simulation.time() < time && outcome.ok) {
      const Result<StepStats> stats = simulation.step(time);
      outcome.ok = stats.ok();
      outcome.steps += 1;
      outcome.iterations += stats ? stats->linear_iterations : 0;
    }
    outcome.seconds += static_cast<double>(std::clock() - clock) / CLOCKS_PER_SEC;
    const double exact = SPEED / frequency * std::sin(frequency * time);
    sum += std::pow((amplitude(simulation, start) - exact) * frequency / SPEED, 2.0);
  }
  outcome.error = outcome.ok ? std::sqrt(sum / SAMPLES) : NAN;
  const Totals totals = simulation.totals();
  outcome.energy = (totals.elastic_energy + totals.kinetic_energy) / put_in;
  return outcome;
}

} // namespace

int main() {
  const Case cases[] = {{"across", Vec3::UnitY()}, {"along", Vec3::UnitX()}};
  std::printf("fibres,method,damping,tolerance,courant,steps,iterations_per_step,cpu_s,error,energy\n");
  for (const Case& which : cases) {
    const auto tell = [&](const char* method, double damping, double tolerance, double courant, MpmPlan plan) {
      const Outcome outcome = run(std::move(plan));
      std::printf("%s,%s,%g,%g,%g,%d,%.3g,%.4g,%.4g,%.4g\n", which.name, method, damping, tolerance, courant,
                  outcome.steps, static_cast<double>(outcome.iterations) / outcome.steps, outcome.seconds,
                  outcome.error, outcome.energy);
      std::fflush(stdout);
    };
    for (const double courant : {0.1, 0.2, 0.4, 0.7}) {
      MpmPlan plan = bar(which);
      plan.settings.courant = courant;
      tell("explicit", 0, 0, courant, std::move(plan));
    }
    for (const auto& [damping, tolerance] : {std::pair(1.0, 0.1), {1.0, 0.01}, {0.0, 0.1}, {0.0, 0.01}}) {
      for (const double courant : {1.0, 2.0, 4.0, 8.0, 16.0, 32.0}) {
        MpmPlan plan = bar(which);
        const double implicitness = damping > 0.0 ? 1.0 : 0.5;
        plan.settings.semi_implicit = SemiImplicit{courant, implicitness, damping, tolerance};
        tell("semi-implicit", damping, tolerance, courant, std::move(plan));
        if (bar(which).settings.cell * courant >= 2.0 * LENGTH / SAMPLES && which.fibre.x() > 0.5)
          break; // samples bound the step
      }
    }
  }
  return 0;
}
