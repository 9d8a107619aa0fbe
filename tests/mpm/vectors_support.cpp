#include "tests/mpm/vectors_support.h"

#include <algorithm>
#include <map>

#include <gtest/gtest.h>

namespace wry::mpm::test {

using nlohmann::json;

Eigen::MatrixXd matrix(const json& rows) {
  Eigen::MatrixXd m(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows.at(0).size()));
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    for (Eigen::Index j = 0; j < m.cols(); ++j)
      m(i, j) = rows.at(static_cast<std::size_t>(i)).at(static_cast<std::size_t>(j)).get<double>();
  }
  return m;
}

Mat3 mat3(const json& rows) {
  return matrix(rows);
}

Vec3 vec3(const json& list) {
  return {list.at(0).get<double>(), list.at(1).get<double>(), list.at(2).get<double>()};
}

OrthotropicElasticity elasticity_of(const json& ortho) {
  OrthotropicElasticity e;
  e.youngs_modulus = vec3(ortho.at("E"));
  e.nu_xy = ortho.at("nu12");
  e.nu_yz = ortho.at("nu23");
  e.nu_xz = ortho.at("nu13");
  if (ortho.contains("mu23_31_12") && !ortho.at("mu23_31_12").is_null())
    e.shear_modulus = vec3(ortho.at("mu23_31_12"));
  return e;
}

Mat6 stress_map_of(const json& input) {
  if (input.contains("A_sigma_mandel"))
    return matrix(input.at("A_sigma_mandel"));
  return stress_map(vec3(input.at("a")));
}

Matter matter_of(const json& input) {
  static const std::map<std::string, Elasticity> ELASTICITIES = {
      {"linear", Elasticity::linear}, {"stvk", Elasticity::hencky}, {"fcr", Elasticity::fixed_corotated}};
  static const std::map<std::string, Plasticity> LAWS = {
      {"dp", Plasticity::drucker_prager}, {"snow", Plasticity::snow}, {"shear", Plasticity::shear}};
  Matter matter;
  matter.elasticity = ELASTICITIES.at(input.at("elasticity"));
  const bool biot = input.contains("measure") ? input.at("measure") == "biot" : matter.elasticity == Elasticity::linear;
  matter.measure = biot ? StrainMeasure::biot : StrainMeasure::hencky;
  matter.conjugacy = input.value("conj", true) ? StressConjugacy::exact : StressConjugacy::literal;
  YieldRule& plasticity = matter.plasticity;
  if (input.contains("plasticity") && !input.at("plasticity").is_null())
    plasticity.law = LAWS.at(input.at("plasticity"));
  if (input.contains("theta_c"))
    plasticity.snow = {input.at("theta_c"), input.at("theta_s"), input.at("xi")};
  if (input.contains("phi_deg") && !input.at("phi_deg").is_null())
    plasticity.friction = {input.at("phi_deg"), 0.0, 0.0, 0.0};
  else if (input.contains("h0_h3"))
    plasticity.friction = {input.at("h0_h3").at(0), input.at("h0_h3").at(1), input.at("h0_h3").at(2),
                           input.at("h0_h3").at(3)};
  plasticity.volume_correction = input.value("vol_corr", false);
  plasticity.flow = input.value("dp_flow", "fictitious") == "isochoric" ? Flow::isochoric : Flow::fictitious;
  plasticity.shear_limit = input.value("shear_max", 0.0025);
  matter.isotropic = false;
  matter.stiffness = orthotropic_stiffness(elasticity_of(input.at("ortho")));
  matter.fictitious = lame_moduli(input.at("Ebar"), input.at("nubar"));
  matter.maps = make_maps(matter.stiffness, matter.fictitious, stress_map_of(input));
  return matter;
}

void expect_close(const Eigen::MatrixXd& actual, const Eigen::MatrixXd& expected, double tolerance,
                  const std::string& what) {
  const double scale = std::max(1e-300, expected.cwiseAbs().maxCoeff());
  EXPECT_LE((actual - expected).cwiseAbs().maxCoeff(), tolerance * scale) << what;
}

} // namespace wry::mpm::test
