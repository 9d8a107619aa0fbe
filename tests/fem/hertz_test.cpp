#include <cmath>
#include <ctime>

#include <gtest/gtest.h>

#include "sim/fem/terms/barrier.h"
#include "tests/fem/solid_support.h"

namespace wry::fem {
namespace {

using namespace test;

constexpr double RADIUS = 1.0; ///< of the ball whose lowest part the body is [m]
constexpr double DEPTH = 0.3;  ///< and width of a quarter [m]
constexpr double START = 1e-4; ///< height at the start [m]
constexpr double YOUNGS_MODULUS = 1e5;
constexpr double POISSON_RATIO = 0.3;
constexpr double ACTIVATION = 2e-5; ///< d-hat [m]
constexpr double STIFFNESS = 1e6;   ///< kappa [N/m]

/// Cells of one size to a bit beyond the contact, then growing.
double graded(double share) {
  constexpr double INNER_SHARE = 0.6;
  constexpr double INNER = 0.11; // [m]
  if (share <= INNER_SHARE)
    return INNER * share / INNER_SHARE;
  const double rest = (share - INNER_SHARE) / (1.0 - INNER_SHARE);
  const double slope = INNER / INNER_SHARE * (1.0 - INNER_SHARE);
  return INNER + slope * rest + (DEPTH - INNER - slope) * rest * rest;
}

/// A quarter of the lowest part of a ball: round below, flat above, where it is pressed down.
std::shared_ptr<const geometry::TetMesh> ball_cap(int cells) {
  std::shared_ptr<geometry::TetMesh> mesh =
      std::make_shared<geometry::TetMesh>(*box_mesh(Vec3(0, 0, 0), Vec3(1, 1, 1), cells, cells, cells));
  for (Eigen::Index i = 0; i < mesh->vertices.rows(); ++i) {
    const double x = graded(mesh->vertices(i, 0));
    const double z = graded(mesh->vertices(i, 2));
    const double height = graded(mesh->vertices(i, 1));
    const double round = (x * x + z * z) / (2.0 * RADIUS);
    mesh->vertices.row(i) << x, START + height + round * (1.0 - height / DEPTH), z;
  }
  return mesh;
}

struct Touch {
  double force = 0.0;  ///< [N]
  double radius = 0.0; ///< of a Hertzian pressure with the same second moment: int p r^2 = 2/5 a^2 F [m]
};

Touch press(int cells) {
  FemPlan plan = plan_of(make_body(ball_cap(cells), ElasticModel::neo_hookean, YOUNGS_MODULUS, POISSON_RATIO));
  plan.planes.push_back({"ground", Vec3::Zero(), Vec3::UnitY(), 0.0});
  DrivenNodes top;
  top.name = "top";
  top.nodes = vertices_at(*plan.bodies[0].mesh, 1, START + DEPTH);
  top.motion = *scene::Motion::along_keys(
      {{{0.0, Vec3::Zero(), Vec3::UnitY(), 0.0}, {1.0, Vec3(0, -0.006, 0), Vec3::UnitY(), 0.0}}, Vec3::Zero()});
  plan.driven.push_back(top);
  for (const int axis : {0, 2}) {
    FixedNodes mirror;
    mirror.name = axis == 0 ? "x" : "z";
    mirror.nodes = vertices_at(*plan.bodies[0].mesh, axis, 0.0);
    mirror.axes = {axis == 0, false, axis == 2};
    plan.fixed.push_back(std::move(mirror));
  }
  plan.settings.contact_distance = ACTIVATION;
  plan.settings.contact_stiffness = STIFFNESS;
  plan.settings.max_time_step = 0.25;
  plan.settings.newton_tolerance = 1e-4;
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  run_until(*simulation, 2.0);
  const Points positions = positions_of(*simulation);
  Touch touch;
  double moment = 0.0;
  for (Eigen::Index i = 0; i < positions.rows(); ++i) {
    if (positions(i, 1) >= ACTIVATION)
      continue;
    const double force = -evaluate_barrier(positions(i, 1), ACTIVATION, STIFFNESS).slope;
    touch.force += force;
    moment += force * (positions(i, 0) * positions(i, 0) + positions(i, 2) * positions(i, 2));
  }
  touch.radius = std::sqrt(2.5 * moment / touch.force);
  touch.force *= 4.0;
  return touch;
}

TEST(Hertz, TheContactRadiusOfABallApproachesTheClosedFormAsCellsShrink) {
  double before = 1.0;
  for (const int cells : {4, 8, 12, 16}) {
    const std::clock_t start = std::clock();
    const Touch touch = press(cells);
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    const double modulus = YOUNGS_MODULUS / (1.0 - POISSON_RATIO * POISSON_RATIO);
    const double expected = std::cbrt(0.75 * touch.force * RADIUS / modulus); // a^3 = 3 F R / (4 E*)
    const double error = std::abs(touch.radius / expected - 1.0);
    std::printf("%d cells: force %.4g N, radius %.5f m, closed form %.5f m, error %.2f %%, %.2f s\n", cells,
                touch.force, touch.radius, expected, 100.0 * error, seconds);
    EXPECT_GT(expected, 0.04);
    EXPECT_LT(error, before);
    before = error;
  }
  EXPECT_LT(before, 0.03);
}

} // namespace
} // namespace wry::fem
