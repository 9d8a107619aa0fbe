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

/// Where the deposit of a quarter ends: where the mean thickness of rings a cell wide, linear between their middles,
/// falls below half a layer of particles for the first time. Experiments measure this front, at a grain's thickness.
double front_of(const Points& x, double particle_volume) {
  std::vector<double> volume;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const auto ring = static_cast<std::size_t>(std::hypot(x(i, 0), x(i, 1)) / CELL);
    volume.resize(std::max(volume.size(), ring + 2), 0.0);
    volume[ring] += particle_volume;
  }
  const double thin = 0.5 * std::cbrt(particle_volume);
  const auto thickness = [&](std::size_t ring) {
    return volume[ring] / (0.25 * std::numbers::pi * (2.0 * static_cast<double>(ring) + 1.0) * CELL * CELL);
  };
  std::size_t ring = 0;
  while (thickness(ring + 1) >= thin) // the last ring is empty
    ++ring;
  const double share = (thickness(ring) - thin) / (thickness(ring) - thickness(ring + 1));
  return (static_cast<double>(ring) + 0.5 + share) * CELL;
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

/// The slope of the line through these points on doubly logarithmic paper.
double exponent(const std::vector<double>& aspects, const std::vector<RunOut>& spread, double low, double high) {
  double n = 0.0, sum_x = 0.0, sum_y = 0.0, sum_xx = 0.0, sum_xy = 0.0;
  for (std::size_t i = 0; i < aspects.size(); ++i) {
    if (aspects[i] < low || aspects[i] > high)
      continue;
    const double x = std::log(aspects[i]), y = std::log(spread[i].front);
    n += 1.0;
    sum_x += x;
    sum_y += y;
    sum_xx += x * x;
    sum_xy += x * y;
  }
  return (n * sum_xy - sum_x * sum_y) / (n * sum_xx - sum_x * sum_x);
}

// Lube et al. 2004: 1.24 a below 1.7, 1.6 sqrt(a) above. Lajeunesse et al. 2004: a below 3, a^1/2 above.
TEST(ColumnScaling, RunsOutInProportionToLowAspectsAndToTheRootOfHighOnes) {
  const std::vector<double> aspects = {0.5, 1.0, 2.0, 4.0, 7.0, 10.0};
  std::vector<RunOut> spread;
  for (const double aspect : aspects) {
    spread.push_back(run_out(aspect));
    const double lube = aspect < 1.7 ? 1.24 * aspect : 1.6 * std::sqrt(aspect);
    std::printf("a = %4.1f  front %.3f  98 %% of the mass %.3f  Lube et al. %.3f\n", aspect, spread.back().front,
                spread.back().most_mass, lube);
    std::fflush(stdout);
  }
  const double low = exponent(aspects, spread, 0.5, 2.0);
  const double high = exponent(aspects, spread, 4.0, 10.0);
  std::printf("exponents of the front: %.2f from .5 to 2, %.2f from 4 to 10\n", low, high);
  EXPECT_NEAR(low, 1.0, 0.25);
  EXPECT_NEAR(high, 0.5, 0.15);
}

} // namespace
} // namespace wry::mpm
