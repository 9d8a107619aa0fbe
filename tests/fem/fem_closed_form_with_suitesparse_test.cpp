#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/fem/micropolar_support.h"

namespace wry::fem {
namespace {

using namespace test;

TEST(FemClosedForm, BendingResistsByTheLengthScale) {
  // Values of another implementation on boxes of this many cells (diagonals may differ); the continuum has 0.19355 and
  // 0.85714, which the bars approach from below as they are refined.
  EXPECT_NEAR(curvature_ratio(0.2, 2), 0.0988, 4e-3);
  EXPECT_NEAR(curvature_ratio(0.2, 4), 0.1564, 4e-3);
  EXPECT_NEAR(curvature_ratio(1.0, 2), 0.7362, 4e-3);
  EXPECT_NEAR(curvature_ratio(1.0, 4), 0.8233, 4e-3);
}

TEST(FemClosedForm, RestCurvatureClosesARing) {
  constexpr double LENGTH = 0.4;
  constexpr double CURVATURE = 2.0 * std::numbers::pi / LENGTH;
  FemPlan plan = curving_bar(0.02, LENGTH, 2, 40, 0.2, CURVATURE);
  plan.settings.max_time_step = 0.05;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  EXPECT_EQ(run_until(*simulation, 1.0), 20);
  const double ratio = measured_curvature(plan, *simulation, LENGTH).norm() / CURVATURE;
  EXPECT_NEAR(ratio, 0.99699, 1e-4);
  EXPECT_NEAR(ratio, 0.99834, 0.003 * 0.99834); // the closed form
  record_number("ring: curvature over rest curvature", 0.99834, ratio);
  // The far end comes back to the clamp, and the middle stands a diameter L / pi away.
  const Points positions = positions_of(*simulation);
  const Points& rest = plan.bodies[0].mesh->vertices;
  Vec3 start = Vec3::Zero();
  Vec3 middle = Vec3::Zero();
  Vec3 end = Vec3::Zero();
  for (Eigen::Index i = 0; i < rest.rows(); ++i) {
    if (rest.row(i).head(2).norm() > 1e-9)
      continue;
    if (std::abs(rest(i, 2)) < 1e-9)
      start = positions.row(i);
    if (std::abs(rest(i, 2) - LENGTH / 2) < 1e-9)
      middle = positions.row(i);
    if (std::abs(rest(i, 2) - LENGTH) < 1e-9)
      end = positions.row(i);
  }
  EXPECT_LT((end - start).norm(), 0.02 * LENGTH);
  EXPECT_NEAR((middle - start).norm(), LENGTH / std::numbers::pi, 0.01 * LENGTH);
}

TEST(FemClosedForm, AFreeBodyKeepsItsMomentum) {
  for (const ElasticModel model : {ElasticModel::neo_hookean, ElasticModel::micropolar}) {
    const FemPlan plan = plan_of(make_body(box_mesh(Vec3::Zero(), Vec3(0.3, 0.2, 0.1), 3, 2, 1), model, 1e4, 0.3));
    const std::unique_ptr<FemSimulation> simulation = simulate(plan);
    StateArchive archive = simulation->archive();
    for (NamedArray& array : archive) {
      for (std::size_t i = 0; array.name == "fem/body0/velocities" && i < array.values.size(); ++i)
        array.values[i] = std::sin(0.9 * static_cast<double>(i));
    }
    ASSERT_TRUE(simulation->restore(archive));
    const Points& rest = plan.bodies[0].mesh->vertices;
    const Tets& tets = plan.bodies[0].mesh->tets;
    const auto momentum = [&] {
      const Eigen::MatrixXd velocity = channel_of(*simulation, "velocity");
      Vec3 sum = Vec3::Zero();
      for (Eigen::Index tet = 0; tet < tets.rows(); ++tet) {
        for (int k = 0; k < 4; ++k)
          sum +=
              1000.0 * 0.3 * 0.2 * 0.1 / static_cast<double>(4 * tets.rows()) * velocity.row(tets(tet, k)).transpose();
      }
      return sum;
    };
    const Vec3 before = momentum();
    ASSERT_GT(before.norm(), 1e-3);
    run_until(*simulation, 0.2);
    EXPECT_LT((momentum() - before).norm(), 2e-7) << rest.rows();
  }
}

} // namespace
} // namespace wry::fem
