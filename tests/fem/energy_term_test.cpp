#include "sim/fem/terms/energy_term.h"

#include <cmath>

#include <gtest/gtest.h>

#include "sim/fem/contact_system.h"
#include "sim/fem/newton.h"
#include "sim/fem/terms/barrier.h"
#include "tests/fem/solid_support.h"

namespace wry::fem {
namespace {

FemBody one_tet(const char* name, ElasticModel model, const Vec3& place) {
  geometry::TetMesh mesh;
  mesh.vertices.resize(4, 3);
  mesh.vertices << 0, 0, 0, 0.03, 0.002, 0.001, 0.004, 0.028, 0, 0.003, 0.001, 0.026;
  mesh.vertices.rowwise() += place.transpose();
  mesh.tets.resize(1, 4);
  mesh.tets << 0, 1, 2, 3;
  FemBody body = test::make_body(std::make_shared<geometry::TetMesh>(mesh), model, 1e4, 0.3);
  body.name = name;
  return body;
}

/// Four nodes of a classic body and four of a micropolar one, near each other and a plane, with friction, all moving.
struct Walk {
  Threads threads{1};
  FemPlan plan;
  FemScene scene;
  std::unique_ptr<ContactSystem> system;
  FemModel model;
  ContactState contact;
  Stage stage;
  Trial trial;
  std::unique_ptr<BlockMatrix> matrix;
  Quaternions rotations = Quaternions::Ones(8, 4).rowwise().normalized();

  Walk() {
    model.layout.append(4, 3);
    model.layout.append(4, 6);
    model.mass = {1.0, 2.0, 0.5, 1.5, 1.0, 0.1, 3.0, 0.7};
    model.rotary_mass = {0.0, 0.0, 0.0, 0.0, 0.2, 0.3, 0.1, 0.5};
    model.body_of_node = {0, 0, 0, 0, 1, 1, 1, 1};
    model.planes.push_back({"slope", Vec3(0, -0.01, 0), Vec3(0.6, 0.8, 0.0), 0.4});
    model.gravity = Vec3(0.3, -9.81, 0.1);
    model.friction_velocity = 0.5;
    model.any_micropolar = model.any_rotary = true;
    model.damping = {1.0, 2.0, 1.0, 2.0, 30.0, 40.0, 30.0, 40.0};
    model.rotations = &rotations;
    model.springs.motions.push_back(
        scene::Motion::along_keys({{{0.0, Vec3(0.1, 0.2, 0.3), Vec3(1, 2, 0), 40.0}}, Vec3::Zero()}).value());
    model.springs.until = {1.0};
    model.loads.push_back({{2, 5},
                           {0.5, 2.0},
                           [](double time) { return Vec3(1.0 + time, 2.0, -3.0); },
                           [](double) { return Vec3(0.4, 0.5, 0.6); }});
    model.springs.nodes = {{1, 0, Vec3(0.1, 0, 0), 50.0, 0.0, false}, {6, 0, Vec3(0, 0.1, 0), 20.0, 30.0, true}};
    contact.distance = 0.05;
    contact.stiffness = {40.0, 90.0};
    contact.ignored.assign(8, 0);
    stage.beta = stage.dt = 0.02;
    plan.bodies.push_back(one_tet("classic", ElasticModel::neo_hookean, Vec3(0.001, 0.002, 0.001)));
    plan.bodies.push_back(one_tet("micropolar", ElasticModel::micropolar, Vec3(0.0192, 0.0221, 0.0213)));
    plan.contact = ContactOptions{true, true, {0.4, 0.4}, {}};
    plan.settings.contact_stiffness = 70.0;
    scene = std::move(build_scene(plan, native_isa(), threads)).value();
    system = std::move(ContactSystem::create(plan, scene, contact.distance, threads, native_isa())).value();
    contact.system = system.get();
    stage.base_positions = stage.start_positions = scene.start_positions;
    stage.base_velocities = wavy(0.4, 2.0);
    stage.base_angular = wavy(0.3, 3.0);
    trial.velocities = wavy(0.03, 4.0);
    trial.angular = wavy(0.2, 5.0);
    update_trial(stage, trial);
    matrix = std::make_unique<BlockMatrix>(
        model.layout, std::vector<std::array<std::int32_t, 4>>{{0, 1, 2, 3}, {4, 5, 6, 7}}, native_isa());
  }

  static Points wavy(double size, double phase) {
    Points points(8, 3);
    for (int i = 0; i < 24; ++i)
      points.data()[i] = size * std::sin(phase + 1.7 * i);
    return points;
  }

  void shift(int dof, double by) {
    for (int node = 0; node < 8; ++node) {
      const int i = dof - static_cast<int>(model.layout.dof(node));
      if (i < 0 || i >= model.layout.dofs(node))
        continue;
      (i < 3 ? trial.velocities(node, i) : trial.angular(node, i - 3)) += by;
    }
    update_trial(stage, trial);
  }
};

class EveryEnergyTerm : public ::testing::TestWithParam<std::size_t> {};

TEST_P(EveryEnergyTerm, HasDerivativesThatDifferencesConfirm) {
  Walk walk;
  const EnergyTermEntry& entry = energy_term_table()[GetParam()];
  const std::unique_ptr<EnergyTerm> term = entry.make(walk.model, walk.contact);
  ASSERT_NE(term, nullptr);
  EXPECT_EQ(term->name(), entry.name);
  term->begin_step(walk.stage, walk.stage.start_positions);
  term->begin_solve(walk.stage, walk.trial);
  const std::size_t size = walk.model.layout.dof_count();
  std::vector<double> gradient(size, 0.0);
  EXPECT_EQ(term->add_gradient(walk.stage, walk.trial, gradient), term->energy(walk.stage, walk.trial));
  double scale = 0.0;
  for (const double value : gradient)
    scale = std::max(scale, std::abs(value));
  EXPECT_GT(scale, 1e-3) << "the walk does not exercise this term";
  term->add_hessian(walk.stage, walk.trial, Projection::none, *walk.matrix);
  walk.matrix->finish_pairs();
  constexpr double STEP = 4e-6;
  for (std::size_t dof = 0; dof < size; ++dof) {
    AlignedVector<double> unit;
    AlignedVector<double> column(walk.model.layout.padded_count());
    std::vector<double> packed(size, 0.0);
    packed[dof] = 1.0;
    pad(walk.model.layout, packed, unit);
    walk.matrix->multiply(unit, column, Threads(1));
    unpad(walk.model.layout, column, packed);
    std::vector<double> above(size, 0.0);
    std::vector<double> below(size, 0.0);
    walk.shift(static_cast<int>(dof), STEP);
    const double energy_above = term->add_gradient(walk.stage, walk.trial, above);
    walk.shift(static_cast<int>(dof), -2.0 * STEP);
    const double energy_below = term->add_gradient(walk.stage, walk.trial, below);
    walk.shift(static_cast<int>(dof), STEP);
    EXPECT_NEAR(gradient[dof], (energy_above - energy_below) / (2.0 * STEP), 1e-7 * std::max(1.0, scale)) << dof;
    for (std::size_t row = 0; row < size; ++row)
      EXPECT_NEAR(packed[row], (above[row] - below[row]) / (2.0 * STEP), 1e-6 * std::max(1.0, scale)) << row << dof;
  }
}

TEST_P(EveryEnergyTerm, LimitsStepsToWhereItIsFinite) {
  Walk walk;
  const std::unique_ptr<EnergyTerm> term = energy_term_table()[GetParam()].make(walk.model, walk.contact);
  const Points down = Points::Constant(8, 3, -100.0);
  const double limit = term->step_limit(walk.trial, down);
  EXPECT_GT(limit, 0.0);
  walk.trial.positions += limit * down;
  EXPECT_TRUE(std::isfinite(term->energy(walk.stage, walk.trial)));
}

INSTANTIATE_TEST_SUITE_P(Table, EveryEnergyTerm, ::testing::Range<std::size_t>(0, energy_term_table().size()),
                         [](const ::testing::TestParamInfo<std::size_t>& tested) {
                           return std::string(energy_term_table()[tested.param].name);
                         });

void expect_bound_above(const EnergyTermEntry& entry) {
  Walk walk;
  const std::unique_ptr<EnergyTerm> term = entry.make(walk.model, walk.contact);
  term->begin_step(walk.stage, walk.stage.start_positions);
  term->begin_solve(walk.stage, walk.trial);
  term->bound_friction(true);
  const std::size_t size = walk.model.layout.dof_count();
  std::vector<double> gradient(size, 0.0);
  const double energy = term->add_gradient(walk.stage, walk.trial, gradient);
  term->add_hessian(walk.stage, walk.trial, Projection::none, *walk.matrix);
  walk.matrix->finish_pairs();
  double closest = 1.0;
  for (const double length : {1e-3, 0.1, 1.0, 30.0}) {
    for (int phase = 0; phase < 8; ++phase) {
      Walk other;
      std::vector<double> way(size, 0.0);
      for (std::size_t dof = 0; dof < size; ++dof) {
        way[dof] = length * std::sin(phase + 2.3 * static_cast<double>(dof));
        other.shift(static_cast<int>(dof), way[dof]);
      }
      AlignedVector<double> in;
      AlignedVector<double> out(walk.model.layout.padded_count());
      pad(walk.model.layout, way, in);
      const double curvature = walk.matrix->multiply(in, out, Threads(1));
      double bound = energy + 0.5 * curvature;
      for (std::size_t dof = 0; dof < size; ++dof)
        bound += gradient[dof] * way[dof];
      const double there = term->energy(walk.stage, other.trial);
      EXPECT_LE(there, bound + 1e-12 * std::abs(bound)) << length << " " << phase;
      closest = std::min(closest, (bound - there) / std::abs(bound));
    }
  }
  EXPECT_LT(closest, 1e-4) << "the bound touches the energy where it was made";
}

TEST(Friction, LiesBelowItsBoundEverywhere) {
  int terms = 0;
  for (const EnergyTermEntry& entry : energy_term_table()) {
    if (entry.name.find("friction") == std::string_view::npos)
      continue;
    expect_bound_above(entry);
    ++terms;
  }
  EXPECT_EQ(terms, 2);
}

TEST(Barrier, PushesApartInsideDhatAndNowhereElse) {
  EXPECT_EQ(evaluate_barrier(0.1, 0.1, 5.0).value, 0.0);
  EXPECT_EQ(evaluate_barrier(0.2, 0.1, 5.0).slope, 0.0);
  // b = -k (d - dhat)^2 ln(d / dhat) at half of d-hat: k dhat^2 / 4 ln 2.
  EXPECT_NEAR(evaluate_barrier(0.05, 0.1, 5.0).value, 5.0 * 0.0025 * std::log(2.0), 1e-15);
  for (const double share : {0.999, 0.5, 1e-3, 1e-9}) {
    const Barrier barrier = evaluate_barrier(0.1 * share, 0.1, 5.0);
    EXPECT_LT(barrier.slope, 0.0);
    EXPECT_GT(barrier.second, 0.0);
  }
  EXPECT_TRUE(std::isinf(evaluate_barrier(0.0, 0.1, 5.0).value));
  EXPECT_TRUE(std::isinf(evaluate_barrier(-1.0, 0.1, 5.0).value));
}

} // namespace
} // namespace wry::fem
