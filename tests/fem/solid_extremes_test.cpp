#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/extreme_table.h"
#include "tests/fem/solid_support.h"

namespace wry::fem {
namespace {

using namespace test;
using wry::test::ExtremeRow;

// The list "Solids" of stiff and extreme cases, each a named case: it converges, or substeps, or is refused with what
// the message must say. Never is a wrong state passed as good.

/// What a case may do to the state before its first step.
using Disturb = std::function<void(Points& positions)>;
/// What must hold of the end.
using Check = std::function<void(const FemPlan& plan, const FemSimulation& simulation)>;

struct Case {
  std::string name;
  FemPlan plan;
  double seconds = 0.05;
  std::string refused; ///< words of the refusal; empty: it holds
  Disturb disturb = {};
  Check check = {};
};

std::ostream& operator<<(std::ostream& out, const Case& one) {
  return out << one.name;
}

constexpr double EDGE = 0.1;

/// A cantilever of 8 x 2 x 2 cells that sags.
FemPlan beam(ElasticModel model, double youngs_modulus = 1e5, double poisson_ratio = 0.3) {
  const std::shared_ptr<const geometry::TetMesh> mesh = box_mesh(Vec3::Zero(), Vec3(0.8, 0.2, 0.2), 8, 2, 2);
  FemPlan plan = plan_of(make_body(mesh, model, youngs_modulus, poisson_ratio));
  plan.gravity = Vec3(0, -9.81, 0);
  plan.fixed.push_back({"clamp", 0, vertices_at(*mesh, 0, 0.0), true, true, {}});
  return plan;
}

FemPlan micropolar_beam(const std::function<void(FemMaterial&)>& change) {
  FemPlan plan = beam(ElasticModel::micropolar);
  plan.bodies[0].material.length_scale = 0.05;
  plan.bodies[0].material.curvature = CurvatureModel::isotropic;
  change(plan.bodies[0].material);
  return plan;
}

/// A free cube of micropolar matter with finite energy at any state.
FemPlan free_cube(ElasticModel model) {
  FemPlan plan = plan_of(make_body(box_mesh(Vec3::Zero(), Vec3(0.2, 0.2, 0.2), 3, 3, 3), model, 1e4, 0.3));
  if (is_micropolar(model))
    plan.bodies[0].material.rotary_inertia = 0.01;
  plan.settings.max_newton_iterations = 200;
  return plan;
}

/// A beam whose ends turn about x in opposite senses.
FemPlan twisted(double degrees_per_second, double degrees) {
  FemPlan plan = beam(ElasticModel::micropolar);
  plan.gravity.setZero();
  plan.fixed.clear();
  for (const double side : {0.0, 1.0}) {
    DrivenNodes drive;
    drive.name = side == 0.0 ? "left" : "right";
    drive.nodes = vertices_at(*plan.bodies[0].mesh, 0, 0.8 * side);
    const double seconds = degrees / degrees_per_second;
    drive.motion = *scene::Motion::along_keys(
        {{{0.0, Vec3::Zero(), Vec3::UnitX(), 0.0}, {seconds, Vec3::Zero(), Vec3::UnitX(), (side - 0.5) * degrees}},
         Vec3(0.8 * side, 0.1, 0.1)});
    plan.driven.push_back(drive);
  }
  return plan;
}

/// The elastic energy after the run is a small part of that after the first step, and the size is the old one.
void expect_cube_again(const FemPlan& plan, const FemSimulation& simulation) {
  const Points now = positions_of(simulation);
  const auto spread = [](const Points& x) { return (x.rowwise() - x.colwise().mean()).rowwise().norm().mean(); };
  EXPECT_NEAR(spread(now), spread(plan.bodies[0].mesh->vertices), 0.2 * spread(plan.bodies[0].mesh->vertices));
}

void expect_bounded(const FemPlan&, const FemSimulation& simulation) {
  EXPECT_LT(positions_of(simulation).cwiseAbs().maxCoeff(), 2.0);
}

void add_collapsed_states(std::vector<Case>& cases) {
  const std::vector<std::pair<std::string, Disturb>> states = {
      {"at one point", [](Points& x) { x.setConstant(0.1); }},
      {"in a plane", [](Points& x) { x.col(1).setConstant(0.1); }},
      {"on a line", [](Points& x) { x.rightCols(2).setConstant(0.1); }},
      {"at random",
       [](Points& x) {
         std::mt19937 generator(7);
         for (double& value : x.reshaped())
           value = 0.2 * static_cast<double>(generator()) / 4294967296.0;
       }},
      {"one tet inverted",
       [](Points& x) {
         const Vec3 first = x.row(20), second = x.row(21);
         x.row(20) = (1.2 * second - 0.2 * first).transpose();
       }},
  };
  for (const auto& [place, disturb] : states) {
    for (const ElasticModel model : {ElasticModel::micropolar, ElasticModel::corotated})
      cases.push_back({std::string(model == ElasticModel::micropolar ? "micropolar" : "corotated") + " nodes " + place,
                       free_cube(model), 1.0, "", disturb,
                       place == "one tet inverted" ? Check(expect_cube_again) : Check(expect_bounded)});
    cases.push_back({"neo-Hookean nodes " + place, free_cube(ElasticModel::neo_hookean), 1.0, "tet", disturb, {}});
  }
}

void add_broken_meshes(std::vector<Case>& cases) {
  const auto with_mesh = [](const std::function<void(geometry::TetMesh&)>& change) {
    FemPlan plan = beam(ElasticModel::neo_hookean);
    std::shared_ptr<geometry::TetMesh> mesh = std::make_shared<geometry::TetMesh>(*plan.bodies[0].mesh);
    change(*mesh);
    plan.bodies[0].mesh = mesh;
    return plan;
  };
  const auto moved = [](double lift) {
    // The last corner of a tet in the corner of the beam, that no other tet has, laid nearly into its face.
    return [lift](geometry::TetMesh& mesh) {
      mesh.vertices.conservativeResize(mesh.vertices.rows() + 1, 3);
      const Eigen::Index last = mesh.vertices.rows() - 1;
      const Vec3 a = mesh.vertices.row(mesh.tets(3, 0)), b = mesh.vertices.row(mesh.tets(3, 1)),
                 c = mesh.vertices.row(mesh.tets(3, 2));
      mesh.vertices.row(last) = ((a + b + c) / 3.0 + lift * (b - a).cross(c - a).normalized()).transpose();
      mesh.tets.conservativeResize(mesh.tets.rows() + 1, 4);
      mesh.tets.row(mesh.tets.rows() - 1) << mesh.tets(3, 0), mesh.tets(3, 1), mesh.tets(3, 2),
          static_cast<std::int32_t>(last);
    };
  };
  cases.push_back({"a tet without volume", with_mesh(moved(0.0)), 0.05, "tet", {}, {}});
  cases.push_back({"a tet with a corner twice",
                   with_mesh([](geometry::TetMesh& mesh) { mesh.tets(5, 1) = mesh.tets(5, 2); }),
                   0.05,
                   "tet",
                   {},
                   {}});
  cases.push_back({"a sliver of 0.01 degrees", with_mesh(moved(1e-5)), 0.05, "", {}, expect_bounded});
}

void add_stiffness(std::vector<Case>& cases) {
  for (const ElasticModel model : {ElasticModel::neo_hookean, ElasticModel::micropolar}) {
    const std::string name = model == ElasticModel::micropolar ? "micropolar" : "neo-Hookean";
    for (int decade = 2; decade <= 12; ++decade)
      cases.push_back({name + " E 1e" + std::to_string(decade), beam(model, std::pow(10.0, decade)), 0.05, "", {}, {}});
    for (const double ratio : {0.45, 0.49, 0.499, 0.4999})
      cases.push_back({fmt::format("{} nu {}", name, ratio), beam(model, 1e5, ratio), 0.05, "", {}, expect_bounded});
    for (const double ratio : {0.5, 0.51, -1.0})
      cases.push_back({fmt::format("{} nu {}", name, ratio), beam(model, 1e5, ratio), 0.05, "ratio", {}, {}});
  }
  FemPlan both = beam(ElasticModel::neo_hookean, 1e2);
  both.bodies[0].factors.youngs_modulus.assign(static_cast<std::size_t>(both.bodies[0].mesh->tets.rows()), 1.0);
  for (std::size_t tet = 0; tet < both.bodies[0].factors.youngs_modulus.size(); tet += 2)
    both.bodies[0].factors.youngs_modulus[tet] = 1e8;
  cases.push_back({"every other tet 1e8 times stiffer", both, 0.05, "", {}, expect_bounded});
}

void add_micropolar_limits(std::vector<Case>& cases) {
  for (const double ratio : {1e-6, 1e-4, 1e-2, 1e2, 1e4, 1e6})
    cases.push_back({fmt::format("mu_c/mu {:g}", ratio),
                     micropolar_beam([&](FemMaterial& m) { m.couple_modulus_ratio = ratio; }),
                     0.05,
                     "",
                     {},
                     expect_bounded});
  for (const double length : {0.0, 1e-9, 0.1 * EDGE, EDGE, 10.0 * EDGE, 1e3})
    cases.push_back({fmt::format("L_c {:g} m", length),
                     micropolar_beam([&](FemMaterial& m) {
                       m.length_scale = length;
                       m.curvature = length > 0.0 ? CurvatureModel::isotropic : CurvatureModel::none;
                     }),
                     0.05,
                     "",
                     {},
                     expect_bounded});
  cases.push_back({"mu_c 0, L_c 0, no rotary inertia",
                   micropolar_beam([](FemMaterial& m) {
                     m.couple_modulus_ratio = m.length_scale = 0.0;
                     m.curvature = CurvatureModel::none;
                   }),
                   0.05,
                   "singular",
                   {},
                   {}});
  // Pulled to twice its length with mu_c < mu: the microrotations could go either way.
  FemPlan pulled = micropolar_beam([](FemMaterial& m) { m.couple_modulus_ratio = 0.1; });
  pulled.gravity.setZero();
  DrivenNodes pull;
  pull.name = "pull";
  pull.nodes = vertices_at(*pulled.bodies[0].mesh, 0, 0.8);
  pull.motion = *scene::Motion::along_keys(
      {{{0.0, Vec3::Zero(), Vec3::UnitX(), 0.0}, {0.5, Vec3(0.8, 0, 0), Vec3::UnitX(), 0.0}}, Vec3::Zero()});
  pulled.driven.push_back(pull);
  cases.push_back({"mu_c < mu, pulled to twice its length",
                   pulled,
                   0.5,
                   "",
                   {},
                   [](const FemPlan& plan, const FemSimulation& simulation) {
                     const std::unique_ptr<FemSimulation> again = simulate(plan);
                     run_until(*again, simulation.time());
                     EXPECT_EQ(hash_of(again->archive()), hash_of(simulation.archive())) << "another branch";
                   }});
}

void add_turns(std::vector<Case>& cases) {
  for (const double degrees : {180.0, 360.0, 720.0}) {
    FemPlan plan = micropolar_beam([](FemMaterial&) {});
    plan.gravity.setZero();
    const double curvature = degrees * std::numbers::pi / 180.0 / 0.8;
    plan.bodies[0].rest_curvature = [curvature](const RestPlace&, double time) {
      Mat3 gamma = Mat3::Zero();
      gamma(2, 0) = time > 0.0 ? curvature : -curvature; // about z, along x
      return gamma;
    };
    cases.push_back({fmt::format("rest curvature flipped by {:g} degrees within a step", degrees),
                     plan,
                     0.2,
                     "",
                     {},
                     expect_bounded});
  }
  for (const double turns : {1.0, 10.0, 100.0})
    cases.push_back({fmt::format("ends turned by {:g} turns a second", turns),
                     twisted(360.0 * turns, 720.0),
                     2.0 / turns,
                     "",
                     {},
                     expect_bounded});
  for (const double degrees : {90.0, 180.0, 359.9, 360.0, 1000.0}) {
    FemPlan plan = twisted(degrees / 0.01, degrees);
    cases.push_back(
        {fmt::format("ends turned by {:g} degrees within a step", degrees), plan, 0.01, "", {}, expect_bounded});
  }
}

void add_steps_and_sizes(std::vector<Case>& cases) {
  for (const double dt : {1e-5, 1e-3, 1e-1, 1.0}) {
    FemPlan plan = beam(ElasticModel::micropolar);
    plan.settings.max_time_step = dt;
    cases.push_back({fmt::format("dt {:g} s", dt), plan, std::min(5.0 * dt, 2.0), "", {}, expect_bounded});
  }
  FemPlan idle =
      plan_of(make_body(box_mesh(Vec3::Zero(), Vec3(0.2, 0.2, 0.2), 1, 1, 1), ElasticModel::micropolar, 1e5, 0.3));
  cases.push_back(
      {"10,000 steps without a load", idle, 100.0, "", {}, [](const FemPlan& plan, const FemSimulation& simulation) {
         EXPECT_LT((positions_of(simulation) - plan.bodies[0].mesh->vertices).cwiseAbs().maxCoeff(), 1e-12);
       }});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<std::string, std::function<void(FemPlan&)>>> spoils = {
      {"gravity", [&](FemPlan& plan) { plan.gravity[1] = nan; }},
      {"a vertex",
       [&](FemPlan& plan) {
         std::shared_ptr<geometry::TetMesh> mesh = std::make_shared<geometry::TetMesh>(*plan.bodies[0].mesh);
         mesh->vertices(3, 1) = nan;
         plan.bodies[0].mesh = mesh;
       }},
      {"Young's modulus", [&](FemPlan& plan) { plan.bodies[0].material.youngs_modulus = nan; }},
      {"density", [&](FemPlan& plan) { plan.bodies[0].material.density = nan; }},
      {"the initial velocity", [&](FemPlan& plan) { plan.bodies[0].initial_velocity[0] = nan; }},
      {"the length scale", [&](FemPlan& plan) { plan.bodies[0].material.length_scale = nan; }},
  };
  for (const auto& [what, spoil] : spoils) {
    FemPlan plan = micropolar_beam([](FemMaterial&) {});
    spoil(plan);
    cases.push_back({"no number in " + what, plan, 0.05, "finite|must lie between", {}, {}});
  }
  for (const double size : {1e-4, 1.0, 1e4}) {
    FemPlan plan =
        plan_of(make_body(box_mesh(Vec3::Zero(), Vec3::Constant(size), 2, 2, 2), ElasticModel::neo_hookean, 1e5, 0.3));
    plan.gravity = Vec3(0, -9.81, 0);
    cases.push_back({fmt::format("a cube of {:g} m", size),
                     plan,
                     0.1,
                     "",
                     {},
                     [size](const FemPlan&, const FemSimulation& simulation) {
                       const double fall = size / 2 - positions_of(simulation).col(1).mean();
                       EXPECT_NEAR(fall, 9.81 * 0.1 * 0.105 / 2, 3e-3);
                     }});
  }
  FemPlan far = beam(ElasticModel::micropolar);
  std::shared_ptr<geometry::TetMesh> mesh = std::make_shared<geometry::TetMesh>(*far.bodies[0].mesh);
  mesh->vertices.array() += 1e6;
  far.bodies[0].mesh = mesh;
  cases.push_back({"1e6 m from the origin", far, 0.1, "", {}, [](const FemPlan& plan, const FemSimulation& simulation) {
                     EXPECT_LT((positions_of(simulation) - plan.bodies[0].mesh->vertices).cwiseAbs().maxCoeff(), 0.1);
                   }});
}

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  add_collapsed_states(cases);
  add_broken_meshes(cases);
  add_stiffness(cases);
  add_micropolar_limits(cases);
  add_turns(cases);
  add_steps_and_sizes(cases);
  return cases;
}

bool says_one_of(const std::string& message, const std::string& words) {
  for (std::size_t at = 0; at <= words.size();) {
    const std::size_t end = std::min(words.find('|', at), words.size());
    if (message.find(words.substr(at, end - at)) != std::string::npos)
      return true;
    at = end + 1;
  }
  return false;
}

Status disturb(FemSimulation& simulation, const Disturb& change) {
  StateArchive archive = simulation.archive();
  for (NamedArray& array : archive) {
    if (array.name != "fem/body0/positions")
      continue;
    Points positions =
        Eigen::Map<const Points>(array.values.data(), static_cast<Eigen::Index>(array.values.size() / 3), 3);
    change(positions);
    std::copy(positions.data(), positions.data() + positions.size(), array.values.begin());
  }
  return simulation.restore(archive);
}

class SolidExtreme : public ::testing::TestWithParam<Case> {};

TEST_P(SolidExtreme, HoldsOrIsRefused) {
  const Case& one = GetParam();
  ExtremeRow row;
  Result<std::unique_ptr<FemSimulation>> made = FemSimulation::create(one.plan, 1, native_isa());
  if (!made)
    row.said = made.error().message;
  if (made && one.disturb) {
    ASSERT_TRUE(disturb(**made, one.disturb));
  }
  double lowest = std::numeric_limits<double>::infinity();
  while (made && row.said.empty() && (*made)->time() < one.seconds) {
    const Result<StepStats> stats = (*made)->step(one.seconds);
    if (!stats) {
      row.said = stats.error().message;
      break;
    }
    ++row.steps;
    row.iterations += stats->newton_iterations;
    row.cuts += stats->cuts;
    row.worst_residual = std::max(row.worst_residual, stats->residual);
    const double energy = stats->elastic_energy + stats->curvature_energy;
    ASSERT_TRUE(std::isfinite(energy) && std::isfinite(stats->kinetic_energy));
    lowest = std::min(lowest, energy);
  }
  row.outcome = !row.said.empty() ? "refuses" : row.cuts > 0 ? "shorter steps" : "holds";
  wry::test::note_extreme("solids", one.name, row);
  EXPECT_EQ(!one.refused.empty(), !row.said.empty()) << row.said;
  if (!one.refused.empty()) {
    EXPECT_TRUE(says_one_of(row.said, one.refused)) << row.said;
  }
  if (row.said.empty()) {
    EXPECT_TRUE(positions_of(**made).allFinite());
    if (one.check)
      one.check(one.plan, **made);
  }
}

std::string name_of(const ::testing::TestParamInfo<Case>& info) {
  std::string name;
  for (const char c : info.param.name)
    name += c == '-' ? 'm' : std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(Solids, SolidExtreme, ::testing::ValuesIn(all_cases()), name_of);

} // namespace
} // namespace wry::fem
