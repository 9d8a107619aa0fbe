#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sim/base/rotation.h"
#include "tests/fem/solid_support.h"

namespace wry::fem {
namespace {

using namespace test;

/// A bar that bends under its weight and under its rest curvature.
FemPlan bent_bar() {
  FemPlan plan =
      plan_of(make_body(box_mesh(Vec3::Zero(), Vec3(0.4, 0.1, 0.1), 4, 1, 2), ElasticModel::micropolar, 1e4, 0.3));
  FemMaterial& material = plan.bodies[0].material;
  material.length_scale = 0.05;
  material.couple_modulus_ratio = 1.5;
  material.curvature = CurvatureModel::orthotropic;
  material.curvature_stiffness << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  plan.gravity = Vec3(0, -2, -9);
  plan.fixed.push_back({"wall", 0, vertices_at(*plan.bodies[0].mesh, 0, 0.0), true, true, {}});
  plan.settings.newton_tolerance = 1e-12;
  return plan;
}

std::size_t tets_of(const FemPlan& plan) {
  return static_cast<std::size_t>(plan.bodies[0].mesh->tets.rows());
}

double distance(const FemPlan& a, const FemPlan& b) {
  const std::unique_ptr<FemSimulation> first = simulate(a);
  const std::unique_ptr<FemSimulation> second = simulate(b);
  run_until(*first, 0.2);
  run_until(*second, 0.2);
  EXPECT_GT((positions_of(*first) - a.bodies[0].mesh->vertices).norm(), 1e-2) << "nothing moved";
  return (positions_of(*first) - positions_of(*second)).cwiseAbs().maxCoeff();
}

TEST(MaterialField, FactorsThatAreTheSameEverywhereAreOtherModuli) {
  FemPlan varied = bent_bar();
  FemPlan scaled = bent_bar();
  MaterialFactors& factors = varied.bodies[0].factors;
  factors.density.assign(tets_of(varied), 1.5);
  factors.youngs_modulus.assign(tets_of(varied), 2.0);
  factors.couple_modulus_ratio.assign(tets_of(varied), 0.5);
  factors.length_scale.assign(tets_of(varied), 3.0);
  FemMaterial& material = scaled.bodies[0].material;
  material.density *= 1.5;
  material.youngs_modulus *= 2.0;
  material.couple_modulus_ratio *= 0.5;
  material.length_scale *= 3.0;
  EXPECT_LT(distance(varied, scaled), 1e-10);
}

TEST(MaterialField, StiffTetsStandWhereTheirFactorsAre) {
  FemPlan plan = bent_bar();
  plan.bodies[0].material.curvature = CurvatureModel::none;
  const geometry::TetMesh& mesh = *plan.bodies[0].mesh;
  std::vector<double>& factors = plan.bodies[0].factors.youngs_modulus;
  for (Eigen::Index tet = 0; tet < mesh.tets.rows(); ++tet) {
    double x = 0.0;
    for (int k = 0; k < 4; ++k)
      x += 0.25 * mesh.vertices(mesh.tets(tet, k), 0);
    factors.push_back(x > 0.2 ? 1e4 : 1.0);
  }
  const std::unique_ptr<FemSimulation> simulation = simulate(plan);
  run_until(*simulation, 0.2);
  // The stiff half keeps its lengths, the soft half does not.
  const Points now = positions_of(*simulation);
  const auto stretch = [&](double from, double to) {
    double most = 0.0;
    for (Eigen::Index tet = 0; tet < mesh.tets.rows(); ++tet) {
      for (int k = 0; k < 4; ++k) {
        for (int l = k + 1; l < 4; ++l) {
          const int a = mesh.tets(tet, k), b = mesh.tets(tet, l);
          const double x = mesh.vertices(a, 0), y = mesh.vertices(b, 0);
          if (std::min(x, y) < from - 1e-9 || std::max(x, y) > to + 1e-9)
            continue;
          const double rest = (mesh.vertices.row(a) - mesh.vertices.row(b)).norm();
          most = std::max(most, std::abs((now.row(a) - now.row(b)).norm() / rest - 1.0));
        }
      }
    }
    return most;
  };
  EXPECT_LT(stretch(0.2, 0.4), 1e-3);
  EXPECT_GT(stretch(0.0, 0.2), 1e-2);
}

TEST(MaterialField, ARestRotationTurnsTheAxesOfCurvatureAndTheDirectors) {
  // Spec §2: strains are of R R0^T, so that a rest rotation turns what stiffness and rest curvature refer to.
  const Vec4 turn = quaternion_exponential(Vec3(0.3, -0.2, std::numbers::pi / 2));
  const Mat3 R0 = rotation_matrix(turn);
  const auto curvature = [](const RestPlace& place, double) {
    Mat3 value = Mat3::Zero();
    value(2, 0) = 3.0 + place.position[0];
    return value;
  };
  FemPlan turned = bent_bar();
  turned.bodies[0].tet_rest_rotations.assign(tets_of(turned), R0);
  turned.bodies[0].vertex_rest_rotations.assign(static_cast<std::size_t>(turned.bodies[0].mesh->vertices.rows()), turn);
  turned.bodies[0].rest_curvature = curvature;
  FemPlan plain = bent_bar();
  plain.bodies[0].material.curvature_basis = R0;
  plain.bodies[0].rest_curvature = curvature;
  EXPECT_LT(distance(turned, plain), 1e-12);
  const std::unique_ptr<FemSimulation> simulation = simulate(turned);
  const Eigen::MatrixXd directors = channel_of(*simulation, "microrotation");
  for (Eigen::Index i = 0; i < directors.rows(); ++i)
    EXPECT_LT(rotation_distance(Vec4(directors.row(i)), turn), 1e-6);
}

TEST(MaterialField, ResetsFollowTheirRuleAndKeepASmallTwistNearTheHistory) {
  const auto energy = [](PointRotations rule) {
    FemPlan plan = bent_bar();
    plan.settings.point_rotations = rule;
    plan.settings.reset_every = 2;
    const std::unique_ptr<FemSimulation> simulation = simulate(plan);
    StepStats stats;
    while (simulation->time() < 0.2)
      stats = simulation->step(0.2).value();
    return stats.elastic_energy + stats.curvature_energy;
  };
  const double history = energy(PointRotations::interpolated_velocity);
  for (const PointRotations rule :
       {PointRotations::rotation_vectors, PointRotations::quaternion_blend, PointRotations::spherical_average}) {
    EXPECT_NE(energy(rule), history);
    EXPECT_NEAR(energy(rule) / history, 1.0, 2e-3);
  }
}

} // namespace
} // namespace wry::fem
