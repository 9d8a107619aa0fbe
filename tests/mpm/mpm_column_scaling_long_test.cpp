#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "tests/mpm/mpm_support.h"

namespace wry::mpm {
namespace {

constexpr double CELL = 0.01;
constexpr double RADIUS = 12 * CELL;

struct RunOut {
  double front = 0.0;     ///< (R - R0) / R0 where the deposit ends
  double most_mass = 0.0; ///< the same where 98 % of the mass is behind: inside the heap, the more so the lower it is
};

/// Where the deposit of a quarter ends: the furthest ring, a cell wide, whose mean thickness is half a layer of
/// particles or more and that is reached without a gap. Experiments measure this front, at a grain's thickness.
double front_of(const Points& x, double particle_volume) {
  std::vector<double> volume;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const auto ring = static_cast<std::size_t>(std::hypot(x(i, 0), x(i, 1)) / CELL);
    volume.resize(std::max(volume.size(), ring + 1), 0.0);
    volume[ring] += particle_volume;
  }
  const double thin = 0.5 * std::cbrt(particle_volume);
  std::size_t ring = 0;
  const auto thickness = [&](std::size_t r) {
    return volume[r] / (0.25 * std::numbers::pi * (2.0 * static_cast<double>(r) + 1.0) * CELL * CELL);
  };
  while (ring < volume.size() && thickness(ring) >= thin)
    ++ring;
  return static_cast<double>(ring) * CELL;
}

/// A cylinder of sand of this aspect ratio H / R0 that is let go on a rough floor: a quarter of it, between two smooth
/// planes, R0 = 12 cells.
RunOut run_out(double aspect) {
  const double height = aspect * RADIUS;
  Material sand = column_material();
  sand.density = 1500.0;
  sand.friction_angle = 31.0 * std::numbers::pi / 180.0;
  // So stiff that the column shortens by no more than about a sixtieth under its weight.
  const double modulus = std::max(5e4, 30.0 * sand.density * 9.81 * height);
  sand.youngs_modulus = {modulus, modulus, modulus};
  SeedSettings seeds;
  seeds.cell = CELL;
  seeds.sampling = Sampling::jittered;
  Result<Seeds> filled = fill(
      Vec3::Zero(), Vec3(RADIUS, RADIUS, height),
      [](const Vec3& x) { return x.head<2>().squaredNorm() <= RADIUS * RADIUS; }, seeds);
  if (!filled)
    return {};
  MpmPlan plan;
  plan.gravity = Vec3(0, 0, -9.81);
  plan.settings.cell = CELL;
  plan.settings.precision = Precision::f32;
  MpmBody body;
  body.name = "column";
  body.material = sand;
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
  add(Vec3::UnitZ(), scene::ColliderContact::sticky, 0.0);
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan), 1);
  // Lube et al. find it at rest after 3.3 sqrt(R0 / g) sqrt(a) or so.
  run_to(*simulation, 4.0 * std::sqrt(height / 9.81) + 2.0 * std::sqrt(RADIUS / 9.81));
  const Points x = channel_of(*simulation, 0, "position");
  return {front_of(x, filled->volume) / RADIUS - 1.0, quantile(x.leftCols(2).rowwise().norm(), 0.98) / RADIUS - 1.0};
}

double exponent(double low, double high, double at_low, double at_high) {
  return std::log(at_high / at_low) / std::log(high / low);
}

// Lube et al. 2004, Lajeunesse et al. 2004: in proportion to a below about 2, to the root of a above.
TEST(ColumnScaling, RunsOutInProportionToLowAspectsAndToTheRootOfHighOnes) {
  const double aspects[] = {0.5, 1.0, 2.0, 4.0, 8.0};
  RunOut spread[5];
  for (int i = 0; i < 5; ++i) {
    spread[i] = run_out(aspects[i]);
    std::printf("a = %4.1f  front %.3f  98 %% of the mass %.3f\n", aspects[i], spread[i].front, spread[i].most_mass);
    std::fflush(stdout);
  }
  const double low = exponent(0.5, 2.0, spread[0].front, spread[2].front);
  const double high = exponent(2.0, 8.0, spread[2].front, spread[4].front);
  std::printf("exponents of the front: %.2f below 2, %.2f above\n", low, high);
  EXPECT_NEAR(low, 1.0, 0.25);
  EXPECT_NEAR(high, 0.5, 0.15);
}

} // namespace
} // namespace wry::mpm
