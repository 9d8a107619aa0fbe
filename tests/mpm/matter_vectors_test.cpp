#include <functional>
#include <map>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "sim/base/rotation.h"
#include "sim/mpm/matter/constitutive_reference.h"
#include "sim/mpm/matter/orientation.h"
#include "tests/mpm/vectors_support.h"
#include "tests/vector_files.h"

namespace wry::mpm {
namespace {

using namespace test;
using nlohmann::json;

Eigen::MatrixXd one(double value) {
  return Eigen::MatrixXd::Constant(1, 1, value);
}

/// One vector: compares what the output names.
class Check {
public:
  explicit Check(const json& vector)
      : m_vector(vector)
      , m_input(vector.at("input"))
      , m_output(vector.at("output"))
      , m_tolerance(vector.at("rel_tol")) {}

  void maps() const {
    const Mat6 A_sigma = stress_map_of(m_input);
    const Mat6 C = orthotropic_stiffness(elasticity_of(m_input.at("ortho")));
    const LameModuli fictitious = lame_moduli(m_input.at("Ebar"), m_input.at("nubar"));
    const AnisotropicMaps found = make_maps(C, fictitious, A_sigma);
    const Mat3 S = mat3(m_input.at("S"));
    matrix_is("A_sigma", A_sigma);
    matrix_is("A_sigma_inv", found.stress_inverse);
    matrix_is("C_tilde", C);
    matrix_is("C_bar", isotropic_stiffness(fictitious));
    matrix_is("A_E", found.strain);
    matrix_is("A_E_inv", found.strain_inverse);
    matrix_is("A_E_S", from_mandel(found.strain * to_mandel(S)));
    matrix_is("A_sigma_S", from_mandel(A_sigma * to_mandel(S)));
  }

  void isotropic_fit() const {
    const auto fit = fit_isotropic(orthotropic_stiffness(elasticity_of(m_input.at("ortho"))), stress_map_of(m_input));
    ASSERT_TRUE(fit) << fit.error().message;
    matrix_is("C_bar", isotropic_stiffness(*fit));
    number_is("lam", fit->lambda);
    number_is("mu", fit->mu);
    number_is("Ebar", fit->mu * (3.0 * fit->lambda + 2.0 * fit->mu) / (fit->lambda + fit->mu));
    number_is("nubar", fit->lambda / (2.0 * (fit->lambda + fit->mu)));
  }

  void ortho_check() const {
    const StiffnessCheck check = check_orthotropic(elasticity_of(m_input));
    EXPECT_EQ(check.positive_definite(), m_output.at("positive_definite").get<bool>()) << id();
    const json& violations = m_output.at("violations");
    ASSERT_EQ(check.violations.size(), violations.size()) << id();
    for (std::size_t i = 0; i < violations.size(); ++i) {
      const std::string text = violations.at(i);
      const double left = std::stod(text.substr(text.find('=') + 1));
      EXPECT_NEAR(check.violations[i].left, left, m_tolerance * std::abs(left)) << id() << ": " << text;
    }
    number_is("min_eig_compliance_scaled", check.least_scaled_eigenvalue);
  }

  void stress() const {
    const Matter matter = matter_of(m_input);
    const ConstitutiveStep step = constitutive_step(matter, mat3(m_input.at("F")), mat3(m_input.at("Q")), {});
    matrix_is("E_local", step.strain);
    matrix_is("E_bar", step.fictitious_strain);
    matrix_is("stress_bar", step.fictitious_stress);
    matrix_is("tau", step.kirchhoff);
    if (m_output.contains("energy_density"))
      number_is("energy_density", elastic_energy_density(matter, step.strain));
  }

  void project() const {
    const PlasticHistory history{m_input.at("Jp"), m_input.at("q"), m_input.at("vc")};
    const ConstitutiveStep step =
        constitutive_step(matter_of(m_input), mat3(m_input.at("F_trial")), mat3(m_input.at("Q")), history);
    matrix_is("F_new", step.F);
    matrix_is("tau", step.kirchhoff);
    matrix_is("E_bar", step.fictitious_strain);
    matrix_is("E_bar_projected", step.projected_strain);
    number_is("Jp", step.history.volume_ratio);
    number_is("q", step.history.flow);
    number_is("vc", step.history.volume_correction);
    EXPECT_EQ(step.yielded, m_output.at("yielded").get<bool>()) << id();
    if (!step.yielded) {
      EXPECT_EQ(step.F, mat3(m_input.at("F_trial"))) << id();
    }
  }

  /// The nodes as they are moved, and APIC's C that the turn is read from.
  void shape_match() const {
    const double h = m_input.at("h"), dt = m_input.at("dt");
    const Vec3 x = vec3(m_input.at("xp"));
    const Eigen::MatrixXd velocities = matrix(m_input.at("node_velocities_27"));
    Mat3 C = Mat3::Zero();
    for (int n = 0; n < 27; ++n) {
      double weight = 1.0;
      Vec3 node;
      for (int axis = 0; axis < 3; ++axis) {
        const int offset = axis == 0 ? n / 9 : axis == 1 ? n / 3 % 3 : n % 3;
        const double base = std::floor(x[axis] / h - 0.5), f = x[axis] / h - base - offset;
        weight *= offset == 1 ? 0.75 - f * f : 0.5 * (1.5 - std::abs(f)) * (1.5 - std::abs(f));
        node[axis] = (base + offset) * h;
      }
      C += 4.0 / (h * h) * weight * velocities.row(n).transpose() * (node - x).transpose();
    }
    matrix_is("C_apic", C);
    matrix_is("dR", frame_turn(C, dt));
    matrix_is("polar_I_dtC", frame_turn(C, dt));
  }

  void pi2() const {
    const Mat3 Pi = mat3(m_input.at("Pi")), D = mat3(m_input.at("D_local"));
    const double l = m_input.at("l");
    const Mat3 next = evolve_second_moment(Pi, D, l, m_input.at("dt"));
    const DiagonalFrame turned = reorient(next);
    matrix_is("Pi_new", next);
    matrix_is("rhs_eq9", second_moment_rate(Pi, D, l));
    matrix_is("dR", turned.turn);
    matrix_is("Pi_reoriented", turned.second_moment);
  }

  void interpolate() const {
    const json& table = m_input.at("iso_perp_par");
    const auto column = [&table](std::size_t i) {
      return AxisParameters{table.at("E").at(i), table.at("nu").at(i), table.at("a").at(i)};
    };
    const OrientationLimits limits{.isotropic = column(0), .parallel = column(2), .perpendicular = column(1)};
    const OrientedParameters found = interpolate_parameters(limits, vec3(m_input.at("lambda3")));
    const Mat6 C = orthotropic_stiffness(found.elasticity());
    vector_is("E", found.youngs_modulus);
    vector_is("nu_per_axis", found.poisson_ratio);
    vector_is("a", found.plastic_scale);
    matrix_is("C_tilde", C);
    const LameModuli fictitious = lame_moduli(m_input.at("Ebar"), m_input.at("nubar"));
    matrix_is("A_E", make_maps(C, fictitious, stress_map(found.plastic_scale)).strain);
  }

private:
  std::string id() const { return m_vector.at("id"); }
  void matrix_is(const char* key, const Eigen::MatrixXd& actual) const {
    expect_close(actual, matrix(m_output.at(key)), m_tolerance, id() + " " + key);
  }
  void vector_is(const char* key, const Vec3& actual) const {
    expect_close(actual, vec3(m_output.at(key)), m_tolerance, id() + " " + key);
  }
  void number_is(const char* key, double actual) const {
    expect_close(one(actual), one(m_output.at(key)), m_tolerance, id() + " " + key);
  }

  const json& m_vector;
  const json& m_input;
  const json& m_output;
  double m_tolerance;
};

TEST(MatterVectors, TheReferenceAnswersEveryVectorOfAMaterial) {
  const std::map<std::string, void (Check::*)() const> checks = {{"maps", &Check::maps},
                                                                 {"isotropic_fit", &Check::isotropic_fit},
                                                                 {"ortho_check", &Check::ortho_check},
                                                                 {"stress", &Check::stress},
                                                                 {"project", &Check::project},
                                                                 {"shape_match", &Check::shape_match},
                                                                 {"pi2", &Check::pi2},
                                                                 {"interpolate", &Check::interpolate}};
  std::map<std::string, int> checked;
  for (const json& vector : wry::test::all_vectors()) {
    const auto check = checks.find(vector.value("kind", ""));
    if (check == checks.end() || !vector.contains("input"))
      continue;
    (Check(vector).*check->second)();
    ++checked[check->first];
  }
  EXPECT_EQ(checked.size(), checks.size());
  EXPECT_GE(checked["project"], 24);
  EXPECT_GE(checked["stress"], 6);
}

} // namespace
} // namespace wry::mpm
