#include "sim/mpm/matter/elasticity_tensor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Dense>
#include <fmt/format.h>

namespace wry::mpm {

namespace {

/// The three ratios in the order xy, yz, xz, each as nu_ij with its axes.
struct Ratio {
  const char* name;
  int i, j;
  double value;
};

std::array<Ratio, 3> ratios(const OrthotropicElasticity& e) {
  return {Ratio{"xy", 0, 1, e.nu_xy}, Ratio{"yz", 1, 2, e.nu_yz}, Ratio{"xz", 0, 2, e.nu_xz}};
}

/// nu_ij sqrt(E_j / E_i): symmetric in the labels, the correlation of the two axes.
double scaled(const Ratio& ratio, const Vec3& E) {
  return ratio.value * std::sqrt(E[ratio.j] / E[ratio.i]);
}

double signed_root_of_product(const Ratio& ratio, const Vec3& E) {
  return scaled(ratio, E); // nu_ij nu_ji = nu_ij^2 E_j / E_i
}

/// Where each ratio alone makes 1 - x^2 - y^2 - z^2 - 2 x y z positive, the other two held.
std::string admissible_alone(const std::array<Ratio, 3>& all, const Vec3& E) {
  std::string text;
  for (std::size_t k = 0; k < 3; ++k) {
    const double y = scaled(all[(k + 1) % 3], E), z = scaled(all[(k + 2) % 3], E);
    const double inside = (1.0 - y * y) * (1.0 - z * z);
    if (std::abs(y) >= 1.0 || std::abs(z) >= 1.0 || inside <= 0.0)
      continue;
    const double unit = std::sqrt(E[all[k].i] / E[all[k].j]);
    text += fmt::format("{}{} in ({:.6g}, {:.6g})", text.empty() ? "" : ", or ", all[k].name,
                        (-y * z - std::sqrt(inside)) * unit, (-y * z + std::sqrt(inside)) * unit);
  }
  return text;
}

void check_moduli(const OrthotropicElasticity& e, std::vector<StiffnessViolation>& violations) {
  constexpr std::array AXES{"x", "y", "z"}, PLANES{"yz", "zx", "xy"};
  for (int i = 0; i < 3; ++i) {
    if (!(e.youngs_modulus[i] > 0.0))
      violations.push_back(
          {fmt::format("E_{} > 0", AXES[static_cast<std::size_t>(i)]), "", e.youngs_modulus[i], 0.0, "(0, inf) Pa"});
  }
  for (int i = 0; e.shear_modulus && i < 3; ++i) {
    if (!((*e.shear_modulus)[i] > 0.0))
      violations.push_back({fmt::format("mu_{} > 0", PLANES[static_cast<std::size_t>(i)]), "", (*e.shear_modulus)[i],
                            0.0, "(0, inf) Pa"});
  }
}

} // namespace

LameModuli lame_moduli(double youngs_modulus, double poisson_ratio) {
  return {youngs_modulus * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio)),
          youngs_modulus / (2.0 * (1.0 + poisson_ratio))};
}

Mat6 isotropic_stiffness(const LameModuli& moduli) {
  Mat6 C = 2.0 * moduli.mu * Mat6::Identity();
  C.topLeftCorner<3, 3>().array() += moduli.lambda;
  return C;
}

Vec3 default_shear_moduli(const OrthotropicElasticity& e) {
  const Vec3& E = e.youngs_modulus;
  const auto all = ratios(e);
  const auto of = [&E](const Ratio& ratio) {
    return std::sqrt(E[ratio.i] * E[ratio.j]) / (2.0 * (1.0 + signed_root_of_product(ratio, E)));
  };
  return {of(all[1]), of(all[2]), of(all[0])};
}

Mat6 orthotropic_compliance(const OrthotropicElasticity& e) {
  const Vec3& E = e.youngs_modulus;
  Mat6 S = Mat6::Zero();
  S.diagonal().head<3>() = E.cwiseInverse();
  for (const Ratio& ratio : ratios(e))
    S(ratio.i, ratio.j) = S(ratio.j, ratio.i) = -ratio.value / E[ratio.i];
  S.diagonal().tail<3>() = (2.0 * e.shear_modulus.value_or(default_shear_moduli(e))).cwiseInverse();
  return S;
}

Mat6 orthotropic_stiffness(const OrthotropicElasticity& e) {
  const Mat6 S = orthotropic_compliance(e);
  Mat6 C = Mat6::Zero();
  C.topLeftCorner<3, 3>() = S.topLeftCorner<3, 3>().inverse();
  C.diagonal().tail<3>() = S.diagonal().tail<3>().cwiseInverse();
  return C;
}

StiffnessCheck check_orthotropic(const OrthotropicElasticity& e) {
  StiffnessCheck check;
  check_moduli(e, check.violations);
  const Vec3& E = e.youngs_modulus;
  if (!(E.minCoeff() > 0.0)) {
    check.least_scaled_eigenvalue = std::numeric_limits<double>::quiet_NaN();
    return check;
  }
  const auto all = ratios(e);
  Mat3 S = Mat3::Identity();
  for (const Ratio& ratio : all) {
    const double limit = std::sqrt(E[ratio.i] / E[ratio.j]);
    const char i = "xyz"[ratio.i], j = "xyz"[ratio.j];
    if (!(std::abs(ratio.value) < limit))
      check.violations.push_back({fmt::format("|nu_{}| < sqrt(E_{} / E_{})", ratio.name, i, j), ratio.name,
                                  std::abs(ratio.value), limit, fmt::format("(-{0:.6g}, {0:.6g})", limit)});
    S(ratio.i, ratio.j) = S(ratio.j, ratio.i) = -scaled(ratio, E);
  }
  const double determinant = S.determinant();
  if (!(determinant > 0.0))
    check.violations.push_back({"1 - nu_xy nu_yx - nu_yz nu_zy - nu_zx nu_xz - 2 nu_yx nu_zy nu_xz > 0", "",
                                determinant, 0.0, admissible_alone(all, E)});
  check.least_scaled_eigenvalue = Eigen::SelfAdjointEigenSolver<Mat3>(S, Eigen::EigenvaluesOnly).eigenvalues()[0];
  return check;
}

namespace {

/// Christoffel's matrix n . C . n, and its largest eigenvalue with its eigenvector.
std::pair<double, Vec3> acoustic_eigenpair(const Mat6& C, const Vec3& n) {
  Mat3 tensor;
  for (int k = 0; k < 3; ++k) {
    const Vec6 stress = C * to_mandel(Vec3::Unit(k) * n.transpose());
    tensor.col(k) = from_mandel(stress) * n;
  }
  const Mat3 symmetric = 0.5 * (tensor + tensor.transpose());
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(symmetric);
  return {solver.eigenvalues()[2], solver.eigenvectors().col(2)};
}

/// The direction of propagation that is best for the polarisation p: the roles of n and p are symmetric in
/// C_ijkl n_j n_l p_i p_k, so alternating never goes down.
double climb(const Mat6& C, Vec3 n) {
  double best = 0.0;
  for (int round = 0; round < 100; ++round) {
    const auto [value, polarisation] = acoustic_eigenpair(C, n);
    if (value <= best * (1.0 + 1e-13))
      return std::max(best, value);
    best = value;
    n = polarisation;
  }
  return best;
}

} // namespace

double stiffest_wave_modulus(const Mat6& stiffness) {
  double best = 0.0;
  constexpr int STARTS = 64; // a Fibonacci lattice over the half-sphere
  for (int i = 0; i < STARTS; ++i) {
    const double z = (i + 0.5) / STARTS, phi = 2.399963229728653 * i;
    const double r = std::sqrt(1.0 - z * z);
    best = std::max(best, climb(stiffness, {r * std::cos(phi), r * std::sin(phi), z}));
  }
  for (int axis = 0; axis < 3; ++axis)
    best = std::max(best, climb(stiffness, Vec3::Unit(axis)));
  return best;
}

} // namespace wry::mpm
