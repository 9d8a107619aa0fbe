#include "tests/mpm/mpm_support.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace wry::mpm {

MpmBody box_of_matter(const Vec3& low, const Vec3& high, double cell, double particles_per_cell,
                      const Material& material) {
  SeedSettings settings;
  settings.cell = cell;
  settings.particles_per_cell = particles_per_cell;
  Result<Seeds> seeds = fill(
      low, high, [](const Vec3&) { return true; }, settings);
  if (!seeds)
    throw std::runtime_error(seeds.error().message);
  MpmBody body;
  body.name = "box";
  body.material = material;
  body.positions = std::make_shared<const Points>(std::move(seeds->positions));
  body.particle_volume = seeds->volume;
  return body;
}

Material column_material() {
  Material material;
  material.name = "sand";
  material.density = 1500.0;
  material.elasticity = Elasticity::hencky;
  material.plasticity = Plasticity::drucker_prager;
  material.youngs_modulus = {5e4, 5e4, 5e4};
  material.poisson_ratio.yz = material.poisson_ratio.xz = material.poisson_ratio.xy = 0.3;
  material.friction_angle = 35.0 * std::numbers::pi / 180.0;
  return material;
}

MpmPlan column_plan(const Material& material, Precision precision) {
  constexpr double CELL = 0.0125;
  MpmPlan plan;
  plan.gravity = Vec3(0, 0, -9.81);
  plan.settings.cell = CELL;
  plan.settings.precision = precision;
  plan.bodies.push_back(
      box_of_matter(Vec3(-3 * CELL, -3 * CELL, 0), Vec3(3 * CELL, 3 * CELL, 12 * CELL), CELL, 8, material));
  auto floor = std::make_shared<scene::Collider>();
  floor->name = "floor";
  floor->shape = scene::PlaneObstacle{Vec3::Zero(), Vec3::UnitZ()};
  floor->contact = scene::ColliderContact::sticky;
  plan.colliders.push_back(floor);
  return plan;
}

int run_to(MpmSimulation& simulation, double end) {
  int steps = 0;
  while (simulation.time() < end) {
    const Result<StepStats> stats = simulation.step(end);
    if (!stats)
      throw std::runtime_error(stats.error().message);
    ++steps;
  }
  return steps;
}

std::unique_ptr<MpmSimulation> make(MpmPlan plan, int threads) {
  Result<std::unique_ptr<MpmSimulation>> made = MpmSimulation::create(std::move(plan), threads, native_isa());
  if (!made)
    throw std::runtime_error(made.error().message);
  return std::move(*made);
}

Points channel_of(const MpmSimulation& simulation, std::size_t body, const std::string& name) {
  const Frame frame = simulation.snapshot(0);
  const wry::Channel* channel = find_channel(frame.bodies.at(body), name);
  if (channel == nullptr || channel->components != 3)
    throw std::runtime_error("no channel " + name);
  return Eigen::Map<const Points>(channel->values.data(), static_cast<Eigen::Index>(channel->values.size() / 3), 3);
}

double quantile(Eigen::VectorXd values, double share) {
  std::sort(values.begin(), values.end());
  const double place = share * static_cast<double>(values.size() - 1);
  const Eigen::Index below = static_cast<Eigen::Index>(place);
  const Eigen::Index above = std::min<Eigen::Index>(below + 1, values.size() - 1);
  return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
}

} // namespace wry::mpm
