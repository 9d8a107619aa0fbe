#include "tests/mpm/column_collapse_support.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "tests/mpm/mpm_support.h"

namespace wry::mpm::test {

namespace {

constexpr double RADIUS = 0.12;

double front_of(const Points& x, double particle_volume, double cell) {
  std::vector<double> volume;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const auto ring = static_cast<std::size_t>(std::hypot(x(i, 0), x(i, 1)) / cell);
    volume.resize(std::max(volume.size(), ring + 2), 0.0);
    volume[ring] += particle_volume;
  }
  const double thin = 0.5 * std::cbrt(particle_volume);
  const auto thickness = [&](std::size_t ring) {
    return volume[ring] / (0.25 * std::numbers::pi * (2.0 * static_cast<double>(ring) + 1.0) * cell * cell);
  };
  std::size_t ring = 0;
  while (thickness(ring + 1) >= thin) // the last ring is empty
    ++ring;
  const double share = (thickness(ring) - thin) / (thickness(ring) - thickness(ring + 1));
  return (static_cast<double>(ring) + 0.5 + share) * cell;
}

MpmPlan plan_of(const ColumnCollapse& column) {
  const double height = column.aspect * RADIUS;
  MpmPlan plan;
  plan.gravity = Vec3(0, 0, -9.81);
  plan.settings.cell = RADIUS / column.cells;
  plan.settings.precision = Precision::f32;
  MpmBody body;
  body.name = "column";
  body.material = column_material();
  body.material.friction_angle = column.friction_degrees * std::numbers::pi / 180.0;
  // So stiff that the column shortens by no more than about a sixtieth under its weight.
  const double modulus = std::max(5e4, 30.0 * body.material.density * 9.81 * height);
  body.material.youngs_modulus = {modulus, modulus, modulus};
  SeedSettings seeds;
  seeds.cell = plan.settings.cell;
  seeds.sampling = Sampling::jittered;
  Result<Seeds> filled = fill(
      Vec3::Zero(), Vec3(RADIUS, RADIUS, height),
      [](const Vec3& x) { return x.head<2>().squaredNorm() <= RADIUS * RADIUS; }, seeds);
  body.positions = std::make_shared<const Points>(std::move(filled->positions));
  body.particle_volume = filled->volume;
  plan.bodies.push_back(std::move(body));
  const auto add = [&](const Vec3& normal, scene::ColliderContact contact, double friction) {
    auto plane = std::make_shared<scene::Collider>();
    plane->shape = scene::PlaneObstacle{Vec3::Zero(), normal};
    plane->contact = contact;
    plane->friction = friction;
    plan.colliders.push_back(plane);
  };
  add(Vec3::UnitX(), scene::ColliderContact::slip, 0.0);
  add(Vec3::UnitY(), scene::ColliderContact::slip, 0.0);
  add(Vec3::UnitZ(), column.floor ? scene::ColliderContact::separate : scene::ColliderContact::sticky,
      column.floor.value_or(0.0));
  return plan;
}

} // namespace

RunOut run_out(const ColumnCollapse& column) {
  MpmPlan plan = plan_of(column);
  const double volume = plan.bodies[0].particle_volume, cell = plan.settings.cell;
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan), 1);
  // Lube et al. find it at rest after 3.3 sqrt(R0 / g) sqrt(a) or so.
  run_to(*simulation, 4.0 * std::sqrt(column.aspect * RADIUS / 9.81) + 2.0 * std::sqrt(RADIUS / 9.81));
  const Points x = channel_of(*simulation, 0, "position");
  return {front_of(x, volume, cell) / RADIUS - 1.0, quantile(x.leftCols(2).rowwise().norm(), 0.98) / RADIUS - 1.0,
          x.col(2).maxCoeff() / RADIUS};
}

} // namespace wry::mpm::test
