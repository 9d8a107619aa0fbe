#include <cmath>
#include <functional>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/fem/micropolar_support.h"

namespace wry::fem {
namespace {

using namespace test;

constexpr double END = 0.2; // [s], about a period of the slowest motion

/// A short bar with curvature energy and rotary inertia: every unknown has waves of its own.
FemPlan shaken_bar(Integrator integrator, int steps) {
  FemPlan plan =
      plan_of(make_body(box_mesh(Vec3::Zero(), Vec3(0.1, 0.1, 0.3), 1, 1, 3), ElasticModel::micropolar, 1e4, 0.3));
  FemMaterial& material = plan.bodies[0].material;
  material.length_scale = 0.05;
  material.curvature = CurvatureModel::isotropic;
  material.rotary_inertia = 10.0;
  plan.settings.integrator = integrator;
  plan.settings.max_time_step = END / steps;
  plan.settings.newton_tolerance = 1e-12;
  plan.settings.linear_tolerance = 1e-10;
  plan.settings.linear_solver = LinearSolver::pcg;
  return plan;
}

/// Positions and microrotations at the end, from smooth velocities at the start.
Eigen::VectorXd shake(const FemPlan& plan) {
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  const Points& rest = plan.bodies[0].mesh->vertices;
  StateArchive archive = simulation->archive();
  for (NamedArray& array : archive) {
    for (Eigen::Index i = 0; i < rest.rows(); ++i) {
      double* out = array.values.data() + 3 * i;
      const double z = 10.0 * rest(i, 2);
      if (array.name == "fem/body0/velocities")
        Eigen::Map<Vec3>(out, 3) = 0.4 * Vec3(std::sin(z), std::cos(z) + 5.0 * rest(i, 0), z * rest(i, 1));
      if (array.name == "fem/body0/angular_velocities")
        Eigen::Map<Vec3>(out, 3) = Vec3(3.0 * std::cos(z), 2.0, 4.0 * std::sin(z));
    }
  }
  EXPECT_TRUE(simulation->restore(archive));
  run_until(*simulation, END);
  const StateArchive state = simulation->archive();
  const NamedArray* positions = nullptr;
  const NamedArray* rotations = nullptr;
  for (const NamedArray& array : state) {
    positions = array.name == "fem/body0/positions" ? &array : positions;
    rotations = array.name == "fem/body0/rotations" ? &array : rotations;
  }
  Eigen::VectorXd all(positions->values.size() + rotations->values.size());
  all << Eigen::Map<const Eigen::VectorXd>(positions->values.data(),
                                           static_cast<Eigen::Index>(positions->values.size())),
      Eigen::Map<const Eigen::VectorXd>(rotations->values.data(), static_cast<Eigen::Index>(rotations->values.size()));
  return all;
}

/// Observed orders of positions and of microrotations.
struct Orders {
  double positions = 0.0, rotations = 0.0;
};

Orders observe(Integrator integrator, int steps, const char* what, const std::function<void(FemPlan&)>& change) {
  const auto run = [&](Integrator with, int count) {
    FemPlan plan = shaken_bar(with, count);
    change(plan);
    return shake(plan);
  };
  const Eigen::VectorXd reference = run(Integrator::sdirk2, 1024);
  const Eigen::VectorXd coarse = run(integrator, steps) - reference;
  const Eigen::VectorXd fine = run(integrator, 2 * steps) - reference;
  const Eigen::Index nodes = reference.size() / 7;
  EXPECT_GT(coarse.head(3 * nodes).norm(), 1e-7) << "nothing moves";
  const Orders orders{std::log2(coarse.head(3 * nodes).norm() / fine.head(3 * nodes).norm()),
                      std::log2(coarse.tail(4 * nodes).norm() / fine.tail(4 * nodes).norm())};
  const double expected = integrator == Integrator::backward_euler ? 1.0 : 2.0;
  const char* name = integrator == Integrator::backward_euler ? "backward Euler"
                     : integrator == Integrator::bdf2         ? "BDF2"
                                                              : "SDIRK2";
  record_number(fmt::format("order of {} in positions, {}", name, what), expected, orders.positions);
  record_number(fmt::format("order of {} in rotations, {}", name, what), expected, orders.rotations);
  return orders;
}

void nothing(FemPlan&) {}

void damped(FemPlan& plan) {
  plan.bodies[0].material.mass_damping = 3.0;
  plan.bodies[0].material.stiffness_damping = 2e-3;
}

/// One end is turned and lifted, starting and ending at rest, the other is pulled by a spring.
void driven(FemPlan& plan) {
  const geometry::TetMesh& mesh = *plan.bodies[0].mesh;
  scene::MotionKeys keys{{{0.0, Vec3::Zero(), Vec3(0, 1, 1), 0.0}, {END, Vec3(0.02, 0, 0), Vec3(0, 1, 1), 40.0}},
                         Vec3(0.05, 0.05, 0),
                         scene::Ease::smooth};
  DrivenNodes exact;
  exact.name = "exact";
  exact.nodes = vertices_at(mesh, 2, 0.0);
  exact.motion = scene::Motion::along_keys(keys).value();
  plan.driven.push_back(exact);
  DrivenNodes soft = exact;
  soft.nodes = vertices_at(mesh, 2, 0.3);
  soft.method = DriveMethod::soft;
  soft.stiffness = 40.0;
  soft.turning_stiffness = 0.5;
  plan.driven.push_back(soft);
}

TEST(TimeOrder, BackwardEulerIsOfFirstOrder) {
  const Orders orders = observe(Integrator::backward_euler, 512, "free", nothing);
  EXPECT_NEAR(orders.positions, 1.0, 0.1);
  EXPECT_NEAR(orders.rotations, 1.0, 0.1);
}

TEST(TimeOrder, Bdf2IsOfSecondOrderInRotationsToo) {
  const Orders orders = observe(Integrator::bdf2, 128, "free", nothing);
  EXPECT_NEAR(orders.positions, 2.0, 0.15);
  EXPECT_NEAR(orders.rotations, 2.0, 0.15);
}

TEST(TimeOrder, Sdirk2IsOfSecondOrderInRotationsToo) {
  const Orders orders = observe(Integrator::sdirk2, 128, "free", nothing);
  EXPECT_NEAR(orders.positions, 2.0, 0.15);
  EXPECT_NEAR(orders.rotations, 2.0, 0.15);
}

class SecondOrder : public ::testing::TestWithParam<Integrator> {};

TEST_P(SecondOrder, IsKeptByDamping) {
  const Orders orders = observe(GetParam(), 128, "damped", damped);
  EXPECT_NEAR(orders.positions, 2.0, 0.2);
  EXPECT_NEAR(orders.rotations, 2.0, 0.2);
}

TEST_P(SecondOrder, IsKeptByDrives) {
  const Orders orders = observe(GetParam(), 128, "driven", driven);
  EXPECT_NEAR(orders.positions, 2.0, 0.2);
  EXPECT_NEAR(orders.rotations, 2.0, 0.2);
}

INSTANTIATE_TEST_SUITE_P(Of, SecondOrder, ::testing::Values(Integrator::bdf2, Integrator::sdirk2),
                         [](const ::testing::TestParamInfo<Integrator>& tested) {
                           return std::string(tested.param == Integrator::bdf2 ? "bdf2" : "sdirk2");
                         });

TEST(TimeOrder, ResumingBdf2FromACheckpointGivesTheSameBits) {
  const FemPlan plan = shaken_bar(Integrator::bdf2, 16);
  const std::unique_ptr<FemSimulation> whole = simulate(plan);
  const std::unique_ptr<FemSimulation> resumed = simulate(plan);
  StateArchive start = whole->archive();
  for (NamedArray& array : start) {
    for (std::size_t i = 0; array.name == "fem/body0/velocities" && i < array.values.size(); ++i)
      array.values[i] = 0.3 * std::sin(0.7 * static_cast<double>(i));
  }
  ASSERT_TRUE(whole->restore(start));
  run_until(*whole, 0.5 * END);
  ASSERT_TRUE(resumed->restore(whole->archive()));
  run_until(*whole, END);
  run_until(*resumed, END);
  EXPECT_EQ(hash_of(whole->archive()), hash_of(resumed->archive()));
}

} // namespace
} // namespace wry::fem
