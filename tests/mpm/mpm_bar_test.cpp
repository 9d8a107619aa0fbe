#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/mpm/mpm_support.h"

namespace wry::mpm {
namespace {

constexpr double LENGTH = 1.0;
constexpr double MODULUS = 1e5;
constexpr double DENSITY = 1000.0;

/// Relative error of Young's modulus as told from the period of the first longitudinal vibration of a free bar.
double error_of_modulus(int cells_along, Transfer transfer) {
  const double cell = LENGTH / cells_along;
  Material material;
  material.name = "bar";
  material.density = DENSITY;
  material.youngs_modulus = {MODULUS, MODULUS, MODULUS};
  material.poisson_ratio.yz = material.poisson_ratio.xz = material.poisson_ratio.xy = 0.0;
  MpmPlan plan;
  plan.gravity = Vec3::Zero();
  plan.settings.cell = cell;
  plan.settings.precision = Precision::f64;
  plan.settings.transfer = transfer;
  plan.settings.courant = 0.2;
  // Ends between nodes, so that no face is favoured.
  const double offset = 0.5 * cell;
  plan.bodies.push_back(box_of_matter(Vec3(offset, offset, offset),
                                      Vec3(LENGTH + offset, 2 * cell + offset, 2 * cell + offset), cell, 8, material));
  const auto mode = [=](double x) { return std::cos(std::numbers::pi * (x - offset) / LENGTH); };
  plan.bodies[0].velocity_field = [=](const Vec3& x) { return Vec3(1e-3 * mode(x.x()), 0, 0); };
  const Points start = *plan.bodies[0].positions;
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
  const auto amplitude = [&] {
    const Points now = channel_of(*simulation, 0, "position");
    double sum = 0.0;
    for (Eigen::Index i = 0; i < now.rows(); ++i)
      sum += (now(i, 0) - start(i, 0)) * mode(start(i, 0));
    return sum;
  };
  // Zeros after half a period and after a whole one.
  const double expected = 2.0 * LENGTH / std::sqrt(MODULUS / DENSITY);
  std::vector<double> zeros;
  double before = 0.0;
  double time_before = 0.0;
  while (zeros.size() < 2) {
    if (!simulation->step(10.0).ok())
      return 1.0;
    const double now = amplitude();
    if (before != 0.0 && before * now < 0.0)
      zeros.push_back(time_before + (simulation->time() - time_before) * before / (before - now));
    before = now;
    time_before = simulation->time();
  }
  const double period = 2.0 * (zeros[1] - zeros[0]);
  return std::abs(std::pow(expected / period, 2.0) - 1.0);
}

TEST(FreeBar, VibratesWithItsModulusWithinOnePercent) {
  EXPECT_LT(error_of_modulus(32, Transfer::gradient), 0.01);
}

TEST(FreeBar, ConvergesToSecondOrder) {
  const double coarse = error_of_modulus(8, Transfer::gradient);
  const double fine = error_of_modulus(16, Transfer::gradient);
  EXPECT_GT(std::log2(coarse / fine), 1.7) << coarse << " " << fine;
}

} // namespace
} // namespace wry::mpm
