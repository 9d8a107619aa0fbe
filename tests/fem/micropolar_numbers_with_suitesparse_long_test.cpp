#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/fem/micropolar_support.h"

namespace wry::fem {
namespace {

using namespace test;

TEST(MicropolarNumbersLong, RestBendingAndTorsionMakeTheHelixOfARod) {
  // Spec §11: kappa = kappa0 K_b A / (K_b A + EI), tau alike; the frame's curvature is (kappa, tau) all along.
  constexpr double LENGTH = 0.4;
  constexpr double WIDTH = 0.02;
  constexpr double BENDING = 3.0 * std::numbers::pi / LENGTH;
  FemPlan plan = curving_bar(WIDTH, LENGTH, 2, 40, 0.2, BENDING, 0.5 * BENDING);
  plan.settings.max_time_step = 1.0 / 30.0;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  EXPECT_EQ(run_until(*simulation, 1.0), 30);
  const double area = WIDTH * WIDTH;
  const double inertia = area * area / 12.0;
  const double kappa = BENDING * 0.04 * area / (0.04 * area + 2.0 * inertia);
  const double tau = 0.5 * BENDING * 0.08 * area / (0.08 * area + 2.0 * 2.0 * inertia);
  // Between a quarter and three quarters the frame turns by more than half a turn: the short way back is measured.
  const double square = kappa * kappa + tau * tau;
  const Vec3 short_way = measured_curvature(plan, *simulation, LENGTH);
  const double full = 2.0 * std::numbers::pi / (0.5 * LENGTH);
  const Vec3 measured = short_way - full * short_way.normalized();
  const double measured_square = measured.squaredNorm();
  const double radius = std::hypot(measured[0], measured[1]) / measured_square;
  const double pitch = 2.0 * std::numbers::pi * std::abs(measured[2]) / measured_square;
  record_number("helix radius [m]", kappa / square, radius);
  record_number("helix pitch [m]", 2.0 * std::numbers::pi * tau / square, pitch);
  EXPECT_NEAR(radius, kappa / square, 0.005 * kappa / square);
  EXPECT_NEAR(pitch, 2.0 * std::numbers::pi * tau / square, 0.005 * 2.0 * std::numbers::pi * tau / square);
}

TEST(MicropolarNumbersLong, TheBendingSizeEffectConvergesAtSecondOrder) {
  struct Row {
    double length_scale, exact;
  };
  for (const Row& row : {Row{0.2, 0.19355}, Row{1.0, 0.85714}}) {
    // The ratio is K / (K + EI (1 + c/n^2)): with 4 and 6 cells c/n^2 is no small part of it yet where EI is most of
    // the stiffness, and an extrapolation at second order is 2.2 % off.
    const double coarse = curvature_ratio(row.length_scale, 8);
    const double fine = curvature_ratio(row.length_scale, 12);
    const double extrapolated = (144.0 * fine - 64.0 * coarse) / 80.0;
    EXPECT_NEAR(extrapolated, row.exact, 0.02 * row.exact);
    record_number(fmt::format("bending size effect at L_c/b = {}", row.length_scale), row.exact, extrapolated);
    const double order = std::log((row.exact - coarse) / (row.exact - fine)) / std::log(1.5);
    EXPECT_NEAR(order, 2.0, 0.2) << row.length_scale;
    record_number(fmt::format("order of the bending size effect at L_c/b = {}", row.length_scale), 2.0, order);
  }
}

TEST(MicropolarNumbersLong, CylinderTorsionAtEveryLengthScale) {
  struct Row {
    double length_scale, exact;
  };
  for (const Row& row : {Row{0.05, 1.00746}, Row{0.2, 1.11720}, Row{1.0, 3.74528}, Row{5.0, 67.77596}}) {
    const double coarse = torsion_ratio(row.length_scale, 8);
    const double fine = torsion_ratio(row.length_scale, 16);
    EXPECT_NEAR((4.0 * fine - coarse) / 3.0, row.exact, 0.01 * row.exact) << row.length_scale;
    record_number(fmt::format("cylinder torsion ratio at L_c/a = {}", row.length_scale), row.exact,
                  (4.0 * fine - coarse) / 3.0);
  }
}

} // namespace
} // namespace wry::fem
