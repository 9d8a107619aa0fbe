#include "sim/mpm/matter/anisotropic_maps.h"

#include <cmath>
#include <numbers>

#include <Eigen/Dense>

namespace wry::mpm {

namespace {

constexpr double ROOT_2_3 = 0.81649658092772603273;

} // namespace

Mat6 congruence_map(const Mat3& D) {
  Mat6 map;
  for (int k = 0; k < 6; ++k)
    map.col(k) = to_mandel(D * from_mandel(Vec6::Unit(k)) * D.transpose());
  return map;
}

Mat6 stress_map(const Vec3& a) {
  Vec6 diagonal;
  diagonal << a[0] * a[0], a[1] * a[1], a[2] * a[2], a[1] * a[2], a[2] * a[0], a[0] * a[1];
  return diagonal.asDiagonal();
}

AnisotropicMaps make_maps(const Mat6& stiffness, const LameModuli& fictitious, const Mat6& stress_map) {
  const Mat6 fictitious_stiffness = isotropic_stiffness(fictitious);
  AnisotropicMaps maps;
  maps.stress_inverse = stress_map.inverse();
  maps.strain = fictitious_stiffness.inverse() * stress_map * stiffness;
  maps.strain_inverse = stiffness.inverse() * maps.stress_inverse * fictitious_stiffness;
  return maps;
}

Result<LameModuli> fit_isotropic(const Mat6& stiffness, const Mat6& stress_map) {
  const Mat6 M = stress_map * stiffness;
  const double bulk = M.topLeftCorner<3, 3>().sum() / 9.0;
  const double mu = (M.trace() - 3.0 * bulk) / 10.0;
  const double lambda = bulk - 2.0 / 3.0 * mu;
  const double nu = lambda / (2.0 * (lambda + mu));
  if (!(mu > 0.0) || !(bulk > 0.0) || !(nu > -1.0 && nu < 0.5))
    return make_error(ErrorCode::bad_input,
                      "the isotropic law nearest to the scaled elasticity has Poisson ratio {:.6g} and shear modulus "
                      "{:.6g} Pa; expected (-1, 0.5) and more than 0: give fictitious = {{ youngs_modulus = ..., "
                      "poisson_ratio = ... }}",
                      nu, mu);
  return LameModuli{lambda, mu};
}

Status check_stress_map(const Mat6& map) {
  const Eigen::JacobiSVD<Mat6> svd(map);
  const double condition = svd.singularValues()[0] / svd.singularValues()[5];
  constexpr double MOST = 1e4;
  if (!map.allFinite() || !(condition < MOST))
    return make_error(ErrorCode::bad_input, "the map has condition number {:.3g}; expected less than {:g}", condition,
                      MOST);
  if (!(map.determinant() > 0.0))
    return make_error(ErrorCode::bad_input, "the map has determinant {:.3g}; expected more than 0", map.determinant());
  return {};
}

Result<double> check_strain_map(const Mat6& strain_map, const LameModuli& fictitious, const Mat6& stress_map) {
  const Mat6 tangent = stress_map.inverse() * isotropic_stiffness(fictitious) * strain_map;
  const Mat6 symmetric = 0.5 * (tangent + tangent.transpose());
  const double least = Eigen::SelfAdjointEigenSolver<Mat6>(symmetric, Eigen::EigenvaluesOnly).eigenvalues()[0];
  if (!(least > 0.0))
    return make_error(ErrorCode::bad_input,
                      "the elastic tangent (A^sigma)^-1 C A^E has the eigenvalue {:.6g} Pa; expected all above 0",
                      least);
  return (tangent - tangent.transpose()).norm() / tangent.norm();
}

double drucker_prager_alpha(double friction_angle) {
  const double sine = std::sin(friction_angle * std::numbers::pi / 180.0);
  return ROOT_2_3 * 2.0 * sine / (3.0 - sine);
}

namespace {

/// The friction angle whose alpha this is; 90 degrees when there is none.
double angle_of_alpha(double alpha) {
  const double sine = 3.0 * alpha / (2.0 * ROOT_2_3 + alpha);
  return sine >= 1.0 ? 90.0 : std::asin(sine) * 180.0 / std::numbers::pi;
}

} // namespace

double least_friction_angle(const Mat6& map) {
  const Mat3 pressure = from_mandel(map * to_mandel(Mat3::Identity()));
  const Mat3 deviator = pressure - pressure.trace() / 3.0 * Mat3::Identity();
  return angle_of_alpha(deviator.norm() / std::abs(pressure.trace()));
}

double least_friction_angle(const Vec3& plastic_scale) {
  return least_friction_angle(stress_map(plastic_scale));
}

} // namespace wry::mpm
