#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <string>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "sim/fem/kernels/kernel_table.h"
#include "tests/fem/kernel_support.h"
#include "tests/vector_files.h"

namespace wry::fem {
namespace {

using nlohmann::json;

std::optional<ElasticModel> model_of(const std::string& key) {
  static const std::map<std::string, ElasticModel> MODELS = {{"mp_lin", ElasticModel::micropolar},
                                                             {"mp_det", ElasticModel::micropolar_det},
                                                             {"mp_nh", ElasticModel::micropolar_neo_hookean},
                                                             {"nh", ElasticModel::neo_hookean},
                                                             {"nh16", ElasticModel::neo_hookean_eq16},
                                                             {"stvk", ElasticModel::stvk},
                                                             {"corot", ElasticModel::corotated}};
  const auto found = MODELS.find(key);
  return found == MODELS.end() ? std::nullopt : std::optional(found->second);
}

CurvatureModel curvature_of(const std::string& key) {
  if (key == "iso")
    return CurvatureModel::isotropic;
  return key == "ortho" ? CurvatureModel::orthotropic : CurvatureModel::none;
}

Eigen::MatrixXd matrix(const json& rows) {
  Eigen::MatrixXd m(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows.at(0).size()));
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    for (Eigen::Index j = 0; j < m.cols(); ++j)
      m(i, j) = rows.at(static_cast<std::size_t>(i)).at(static_cast<std::size_t>(j)).get<double>();
  }
  return m;
}

/// One element as the vector describes it. `curved` false leaves the curvature energy out.
KernelSample sample_of(const json& vector, bool curved) {
  const json& params = vector.at("params");
  const ElasticModel model = *model_of(vector.at("model"));
  const double mu = params.at("mu"), mu_c = params.at("mu_c"), L_c = params.at("L_c"), dt = vector.at("dt");
  KernelCase kernel_case{.model = model, .couple_equals_shear = mu == mu_c, .has_rest_curvature = true};
  kernel_case.curvature = curved ? curvature_of(vector.at("curv")) : CurvatureModel::none;
  const Mat3 basis = matrix(params.at("basis_columns"));
  kernel_case.has_basis = kernel_case.curvature == CurvatureModel::orthotropic && basis != Mat3::Identity();
  KernelSample sample = empty_sample(kernel_case, 1);
  ElementGroup& group = sample.group;

  const Eigen::MatrixXd X = matrix(vector.at("X"));
  Mat3 edges;
  for (int k = 0; k < 3; ++k)
    edges.col(k) = (X.row(k + 1) - X.row(0)).transpose();
  const Mat3 gradients = edges.inverse();
  for (int i = 0; i < 9; ++i)
    group_entry(group.shape_gradients, 0, 9, i) = gradients(i / 3, i % 3);
  group.volume[0] = std::abs(edges.determinant()) / 6.0;
  group.mu[0] = mu;
  group.lambda[0] = params.at("lambda_");
  group.mu_c[0] = mu_c;

  const Eigen::MatrixXd x0 = matrix(vector.at("x0")), v = matrix(vector.at("v")), omega = matrix(vector.at("omega"));
  const Eigen::MatrixXd q_nodal = matrix(vector.at("q0_nodal")), q_quad = matrix(vector.at("q0_quad"));
  for (int i = 0; i < 12; ++i) {
    sample.positions[static_cast<std::size_t>(i)] = x0(i / 3, i % 3) + dt * v(i / 3, i % 3);
    sample.increments[static_cast<std::size_t>(i)] = dt * omega(i / 3, i % 3);
  }
  for (int i = 0; i < 16; ++i)
    sample.rotations[static_cast<std::size_t>(i)] = q_nodal(i / 4, i % 4);
  if (!is_micropolar(model))
    return sample;
  for (int i = 0; i < 16; ++i)
    group_entry(group.point_rotations, 0, 16, i) = q_quad(i / 4, i % 4);
  const double scale = mu * L_c * L_c;
  if (kernel_case.curvature == CurvatureModel::isotropic) {
    int i = 0;
    for (const char* key : {"alpha", "beta", "gamma"})
      group_entry(group.curvature_moduli, 0, 3, i++) = scale * params.at(key).get<double>();
  }
  if (kernel_case.curvature == CurvatureModel::orthotropic) {
    const Mat3 C = matrix(params.at("C"));
    for (int i = 0; i < 9; ++i)
      group_entry(group.curvature_moduli, 0, 9, i) = scale * C(i / 3, i % 3);
  }
  for (int i = 0; kernel_case.has_basis && i < 9; ++i)
    group_entry(group.curvature_basis, 0, 9, i) = basis(i / 3, i % 3);
  if (kernel_case.curvature != CurvatureModel::none) {
    for (int p = 0; p < POINTS; ++p) {
      const Mat3 Gamma0 = matrix(vector.at("Gamma0_quad").at(static_cast<std::size_t>(p)));
      for (int i = 0; i < 9; ++i)
        group_entry(group.rest_curvature, 0, 36, 9 * p + i) = Gamma0(i / 3, i % 3);
    }
  }
  return sample;
}

/// Derivatives by all 24 (v, omega) from those by (x, a) of the model's dofs.
Eigen::VectorXd spread(const Eigen::VectorXd& gradient, double dt) {
  Eigen::VectorXd all = Eigen::VectorXd::Zero(24);
  const Eigen::Index dofs = gradient.size() / 4;
  for (Eigen::Index k = 0; k < 4; ++k)
    all.segment(6 * k, dofs) = dt * gradient.segment(dofs * k, dofs);
  return all;
}

Eigen::MatrixXd spread(const Eigen::MatrixXd& hessian, double dt) {
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(24, 24);
  const Eigen::Index dofs = hessian.rows() / 4;
  for (Eigen::Index k = 0; k < 4; ++k) {
    for (Eigen::Index l = 0; l < 4; ++l)
      all.block(6 * k, 6 * l, dofs, dofs) = dt * dt * hessian.block(dofs * k, dofs * l, dofs, dofs);
  }
  return all;
}

/// The largest error so far, as a share of what the vectors' head allows.
struct Worst {
  double error = 0.0; ///< relative to the scale
  void take(double difference, double scale, double tolerance, const std::string& what) {
    const double relative = difference / scale;
    EXPECT_LE(relative, tolerance) << what;
    if (!(relative <= error))
      error = relative;
  }
};

struct Tally {
  int checked = 0, hessians = 0;
  Worst energy, gradient, hessian;
};

void check(const json& vector, Isa isa, Tally& tally) {
  const std::string id = vector.at("id").get<std::string>() + " " + std::string(isa_name(isa));
  const json& out = vector.at("out");
  const double dt = vector.at("dt"), mu = vector.at("params").at("mu"), volume = out.at("volume");
  const std::string model = vector.at("model");
  const bool rest = vector.at("note").get<std::string>().rfind("rest state", 0) == 0;
  const double tolerance = model == "corot" ? 1e-9 : 1e-11;
  const ElementResults all = evaluate(sample_of(vector, true), isa);
  const ElementResults strain = evaluate(sample_of(vector, false), isa);
  ++tally.checked;

  const double E_int = out.at("E_int"), E_mp = out.at("E_mp"), E_curv = out.at("E_curv");
  const bool floor = rest || model == "nh" || model == "nh16" || model == "mp_nh";
  const auto scale = [&](double E) {
    return rest ? mu * volume : floor ? std::max(std::abs(E), mu * volume) : std::abs(E);
  };
  tally.energy.take(std::abs(all.energy[0] - E_int), scale(E_int), tolerance, id + " E_int");
  tally.energy.take(std::abs(strain.energy[0] - E_mp), scale(E_mp), tolerance, id + " E_mp");
  if (E_curv != 0.0)
    tally.energy.take(std::abs(all.energy[0] - strain.energy[0] - E_curv), std::abs(E_int), tolerance, id + " E_curv");

  Eigen::VectorXd gradient(24);
  for (Eigen::Index i = 0; i < 24; ++i)
    gradient[i] = out.at("grad").at(static_cast<std::size_t>(i)).get<double>();
  const double gradient_scale = rest ? dt * mu * std::pow(volume, 2.0 / 3.0) : gradient.cwiseAbs().maxCoeff();
  tally.gradient.take((spread(all.gradient[0], dt) - gradient).cwiseAbs().maxCoeff(), gradient_scale, tolerance,
                      id + " grad");

  const Eigen::MatrixXd hessian = spread(all.hessian[0], dt);
  const double norm = out.at("hess_frobenius");
  tally.hessian.take(std::abs(hessian.norm() - norm), norm, 1e-9, id + " hess_frobenius");
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(hessian, Eigen::EigenvaluesOnly);
  tally.hessian.take(std::abs(eigen.eigenvalues()[0] - out.at("hess_eig_min").get<double>()), norm, 1e-9,
                     id + " hess_eig_min");
  tally.hessian.take(std::abs(eigen.eigenvalues()[23] - out.at("hess_eig_max").get<double>()), norm, 1e-9,
                     id + " hess_eig_max");
  if (out.contains("hess")) {
    const Eigen::MatrixXd expected = matrix(out.at("hess"));
    tally.hessian.take((hessian - expected).cwiseAbs().maxCoeff(), expected.cwiseAbs().maxCoeff(), tolerance,
                       id + " hess");
    ++tally.hessians;
  }
}

TEST(KernelVectors, EnergyGradientAndHessianAreThoseOfTheReference) {
  Tally tally;
  int tets = 0, plates = 0;
  std::map<std::string, int> uncovered;
  for (const json& vector : test::all_vectors()) {
    const std::string kind = vector.value("kind", "");
    plates += kind == "plate" ? 1 : 0;
    if (kind != "tet")
      continue;
    ++tets;
    const auto model = model_of(vector.at("model"));
    if (!model || find_kernel(*model, Isa::sse4) == nullptr) {
      ++uncovered[vector.at("model")];
      continue;
    }
    for (const Isa isa : runnable_isas())
      check(vector, isa, tally);
  }
  const int sets = static_cast<int>(runnable_isas().size());
  std::printf("tet vectors: %d of %d checked on %d instruction sets, %d with a whole Hessian\n", tally.checked / sets,
              tets, sets, tally.hessians / sets);
  std::printf("worst relative error: energy %.2g, gradient %.2g, Hessian %.2g\n", tally.energy.error,
              tally.gradient.error, tally.hessian.error);
  std::printf("not covered here: %d plate vectors (mixed_kernel_test.cpp has them)\n", plates);
  for (const auto& [model, count] : uncovered)
    std::printf("not covered: %d vectors of model %s\n", count, model.c_str());
  EXPECT_GE(tets, 36) << "the vectors of tests/data/vectors are missing";
  EXPECT_TRUE(uncovered.empty());
}

} // namespace
} // namespace wry::fem
