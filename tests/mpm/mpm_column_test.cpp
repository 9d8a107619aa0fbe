#include <gtest/gtest.h>

#include "tests/mpm/mpm_support.h"

namespace wry::mpm {
namespace {

constexpr double CELL = 0.0125;
constexpr double HALF_WIDTH = 3 * CELL;

struct Pile {
  double x, y, height; ///< run-out along x and y and greatest height, over the half width
};

Pile collapse(const Material& material, const Mat3& frame = Mat3::Identity()) {
  MpmPlan plan = column_plan(material, Precision::f64);
  plan.bodies[0].frame = frame;
  const std::unique_ptr<MpmSimulation> simulation = make(std::move(plan));
  run_to(*simulation, 0.5);
  const Points x = channel_of(*simulation, 0, "position");
  return {quantile(x.col(0).cwiseAbs(), 0.98) / HALF_WIDTH - 1.0,
          quantile(x.col(1).cwiseAbs(), 0.98) / HALF_WIDTH - 1.0, x.col(2).maxCoeff() / HALF_WIDTH};
}

void expect_near(const Pile& pile, const Pile& wanted) {
  EXPECT_NEAR(pile.x, wanted.x, 0.1 * wanted.x);
  EXPECT_NEAR(pile.y, wanted.y, 0.1 * wanted.y);
  EXPECT_NEAR(pile.height, wanted.height, 0.1 * wanted.height);
}

Material scaled(double along_fibre) {
  Material material = column_material();
  material.plastic_scale = {1, 1, along_fibre};
  return material;
}

/// Local z along the world's x.
Mat3 fibre_along_x() {
  Mat3 frame;
  frame << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return frame;
}

// Numbers of an independent computation: 98 % quantile of the spread, over the half width, minus 1; height over it.
TEST(Column, IsotropicSpreadsAsItShould) {
  expect_near(collapse(column_material()), {1.52, 1.52, 1.08});
}

TEST(Column, WeakVerticalStandsLower) {
  expect_near(collapse(scaled(0.5)), {1.66, 1.66, 0.88});
}

TEST(Column, StrongVerticalPushesOutFurther) {
  expect_near(collapse(scaled(1.5)), {2.51, 2.51, 1.12});
}

TEST(Column, WeakFibreAlongXSpreadsAlongX) {
  expect_near(collapse(scaled(0.6), fibre_along_x()), {3.28, 1.54, 1.04});
}

TEST(Column, StrongFibreAlongXSpreadsAcross) {
  expect_near(collapse(scaled(1.5), fibre_along_x()), {1.47, 1.72, 0.95});
}

} // namespace
} // namespace wry::mpm
