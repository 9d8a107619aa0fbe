#include <cmath>
#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "sim/base/rotation.h"
#include "sim/mpm/matter/constitutive_reference.h"
#include "sim/mpm/matter/make_matter.h"
#include "sim/mpm/matter/plastic_law.h"
#include "sim/mpm/matter/stretch.h"
#include "tests/extreme_table.h"
#include "tests/mpm/matter_tiles_support.h"

namespace wry::mpm {
namespace {

constexpr double DEGREE = 0.017453292519943295;

Mat3 exponential(const Mat3& S) {
  const SymmetricEigen eigen = symmetric_eigen(S);
  const Vec3 values = eigen.values.array().exp();
  return eigen.vectors * values.asDiagonal() * eigen.vectors.transpose();
}

Matter matter_of(const Material& material) {
  const auto matter = make_matter(material);
  EXPECT_TRUE(matter) << (matter ? "" : matter.error().message);
  return *matter;
}

Material grains(const Vec3& a, double phi) {
  Material material;
  material.youngs_modulus = {1e5, 2e5, 3e5};
  material.poisson_ratio = {0.2, 0.15, 0.3};
  material.plastic_scale = {a[0], a[1], a[2]};
  material.plasticity = Plasticity::drucker_prager;
  material.friction_angle = phi * DEGREE;
  return material;
}

TEST(MatterFacts, SimpleShearSlidesWithTheFrictionOfItsPlane) {
  for (const Vec3& a : {Vec3(1, 1, 1), Vec3(0.8, 1.0, 1.2), Vec3(1.1, 0.9, 1.0)}) {
    const Matter matter = matter_of(grains(a, 30.0));
    const double alpha = drucker_prager_alpha(30.0);
    for (int n = 0; n < 3; ++n) {
      const int s = (n + 1) % 3;
      const Mat3 pressed = from_mandel(matter.maps.strain_inverse * to_mandel(-1e-5 * Mat3::Identity()));
      Mat3 F = exponential(pressed), slip = Mat3::Zero();
      slip(s, n) = 1e-6;
      Mat3 tau;
      for (int i = 0; i < 400; ++i) {
        const ConstitutiveStep step = constitutive_step(matter, (Mat3::Identity() + slip) * F, Mat3::Identity(), {});
        F = step.F;
        tau = step.kirchhoff;
      }
      const double expected = a[n] / a[s] * 3.0 * alpha / std::sqrt(2.0);
      EXPECT_NEAR(std::abs(tau(s, n) / tau(n, n)), expected, 1e-3 * expected) << a.transpose() << ", plane " << n;
    }
  }
}

TEST(MatterFacts, TriaxialCompressionYieldsWhereTheConeSays) {
  const double phi = 30.0, alpha = drucker_prager_alpha(phi), root = std::sqrt(2.0 / 3.0), p = 100.0;
  for (int k = 0; k < 3; ++k) {
    for (const double a_k : {0.8, 1.0, 1.3}) {
      Vec3 a = Vec3::Ones();
      a[k] = a_k;
      const Matter matter = matter_of(grains(a, phi));
      const double axial = p * (root + 2.0 * alpha) / (a_k * a_k * (root - alpha));
      const auto yields = [&](double stress) {
        Vec3 sigma = Vec3::Constant(-p);
        sigma[k] = -stress;
        const Mat3 strain = from_mandel(matter.stiffness.inverse() * to_mandel(sigma.asDiagonal().toDenseMatrix()));
        return constitutive_step(matter, exponential(strain), Mat3::Identity(), {}).yielded;
      };
      EXPECT_FALSE(yields(axial * (1.0 - 1e-6))) << k << " " << a_k;
      EXPECT_TRUE(yields(axial * (1.0 + 1e-6))) << k << " " << a_k;
    }
  }
}

TEST(MatterFacts, AStretchedBlockHasItsModuliAndRatios) {
  const Material material = [] {
    Material m = grains(Vec3::Ones(), 30.0);
    m.plasticity = Plasticity::none;
    return m;
  }();
  const Mat6 S = matter_of(material).stiffness.inverse();
  constexpr int PULLED[] = {0, 1, 2};
  for (const int i : PULLED) {
    const double stress = 1e-7 * material.youngs_modulus[static_cast<std::size_t>(i)];
    Mat3 sigma = Mat3::Zero();
    sigma(i, i) = stress;
    const Mat3 strain = from_mandel(S * to_mandel(sigma));
    std::vector<test::Sample> samples(1);
    samples[0].F = exponential(strain);
    test::run_kernel<double>(material, native_isa(), 0.0, samples);
    EXPECT_NEAR(samples[0].tau(i, i) / strain(i, i), material.youngs_modulus[static_cast<std::size_t>(i)],
                1e-5 * material.youngs_modulus[static_cast<std::size_t>(i)]);
    EXPECT_LT(std::abs(samples[0].tau((i + 1) % 3, (i + 1) % 3)), 1e-5 * stress); // nothing holds its sides
  }
  const Mat3 along_x = from_mandel(S * to_mandel(Vec3(1, 0, 0).asDiagonal().toDenseMatrix()));
  EXPECT_NEAR(-along_x(1, 1) / along_x(0, 0), material.poisson_ratio.xy, 1e-12);
  EXPECT_NEAR(-along_x(2, 2) / along_x(0, 0), material.poisson_ratio.xz, 1e-12);
}

TEST(MatterFacts, FibresAlongAcrossAndAnyhowToALoadGiveTheModulusOfTheClosedForm) {
  const Material material = [] {
    Material m = grains(Vec3::Ones(), 30.0);
    m.plasticity = Plasticity::none;
    m.youngs_modulus = {1e5, 1e5, 1e7};
    m.poisson_ratio.yz = m.poisson_ratio.xz = 0.003;
    return m;
  }();
  const Mat6 S = matter_of(material).stiffness.inverse();
  const double two_mu_zx = 1.0 / S(4, 4);
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 20; ++k) {
    // The angle between the load (world x) and the fibre (local z): 0, 90 degrees, or any.
    const Vec3 fibre = k == 0   ? Vec3(Vec3::UnitX())
                       : k == 1 ? Vec3(Vec3::UnitY())
                                : Vec3(normal(random), normal(random), normal(random)).normalized();
    const Eigen::Quaterniond frame = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), fibre);
    // 1 / E = c^4 / E_z + s^4 / E_x + c^2 s^2 (2 S_xz + 2 / (2 mu_zx)) of a material that is alike about its fibre.
    const double c2 = std::pow(fibre.x(), 2.0), s2 = 1.0 - c2;
    const double modulus = 1.0 / (c2 * c2 / 1e7 + s2 * s2 / 1e5 + 2.0 * c2 * s2 * (S(0, 2) + 1.0 / two_mu_zx));
    const Mat3 Q = frame.toRotationMatrix();
    Mat3 sigma = Mat3::Zero();
    sigma(0, 0) = 1e-6 * modulus;
    const Mat3 strain = Q * from_mandel(S * to_mandel(Q.transpose() * sigma * Q)) * Q.transpose();
    EXPECT_NEAR(sigma(0, 0) / strain(0, 0), modulus, 1e-9 * modulus) << fibre.transpose(); // the form itself
    std::vector<test::Sample> samples(1);
    samples[0].F = exponential(strain);
    samples[0].frame = Vec4(frame.w(), frame.x(), frame.y(), frame.z());
    test::run_kernel<double>(material, native_isa(), 0.0, samples);
    EXPECT_NEAR(samples[0].tau(0, 0) / strain(0, 0), modulus, 0.01 * modulus) << fibre.transpose();
    if (k < 3)
      wry::test::note_extreme("particles",
                              fmt::format("a fibre {} the load", k == 0   ? "along"
                                                                 : k == 1 ? "across"
                                                                          : "anyhow to"),
                              {"holds", 0, 0, 0, std::abs(samples[0].tau(0, 0) / strain(0, 0) / modulus - 1.0), ""});
    EXPECT_LT(Mat3(samples[0].tau - sigma).norm(), 0.01 * sigma(0, 0)); // nothing else holds it
  }
}

TEST(MatterFacts, ElasticStressOfLinearLawsDoesNotKnowTheMaps) {
  for (const Elasticity law : {Elasticity::linear, Elasticity::hencky}) {
    Material plain = grains(Vec3::Ones(), 30.0), scaled = grains(Vec3(0.7, 1.1, 1.4), 30.0);
    for (Material* material : {&plain, &scaled}) {
      material->elasticity = law;
      material->plasticity = Plasticity::none;
    }
    scaled.fictitious = Material::Isotropic{7e5, 0.1};
    Mat3 F;
    F << 1.1, 0.2, -0.1, 0.05, 0.9, 0.15, -0.2, 0.1, 1.05;
    const Mat3 Q = rodrigues(Vec3(0.3, -0.5, 0.8));
    const Mat3 a = constitutive_step(matter_of(plain), F, Q, {}).kirchhoff;
    const Mat3 b = constitutive_step(matter_of(scaled), F, Q, {}).kirchhoff;
    EXPECT_LT((a - b).norm(), 1e-10 * a.norm());
  }
}

TEST(MatterFacts, HydrostaticFlowIsWarnedOfWithTheAngleThatCarriesIt) {
  EXPECT_NEAR(least_friction_angle(Vec3(0.8, 0.8, 1.4)), 30.5, 0.05);
  EXPECT_NEAR(least_friction_angle(Vec3(1, 1, 2)), 36.9, 0.05);
  EXPECT_NEAR(least_friction_angle(Vec3(1, 1, 1.5)), 22.6, 0.05);
  EXPECT_NEAR(least_friction_angle(Vec3(1, 1, 0.5)), 25.4, 0.05);
  const auto warnings = [](double phi) { return compile_material(grains(Vec3(0.8, 0.8, 1.4), phi))->warnings.size(); };
  EXPECT_EQ(warnings(30.0), 1u);
  EXPECT_EQ(warnings(31.0), 0u);
  const Matter matter = matter_of(grains(Vec3(0.8, 0.8, 1.4), 30.0)); // and it does flow
  const Mat3 strain = from_mandel(matter.stiffness.inverse() * to_mandel(-100.0 * Mat3::Identity()));
  EXPECT_TRUE(constitutive_step(matter, exponential(strain), Mat3::Identity(), {}).yielded);
}

TEST(MatterFacts, AnImpossibleElasticityIsRefusedWithWhatIsPossible) {
  Material material = grains(Vec3::Ones(), 30.0);
  material.poisson_ratio.xy = 0.9; // sqrt(E_x / E_y) = .707
  const auto refused = compile_material(material);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("|nu_xy| < sqrt(E_x / E_y)"), std::string::npos) << refused.error().message;
  EXPECT_NE(refused.error().message.find("(-0.707107, 0.707107)"), std::string::npos) << refused.error().message;
  // All three ratios below their own limits, but too large together: each interval's ends are singular.
  OrthotropicElasticity e;
  e.nu_xy = e.nu_yz = e.nu_xz = -0.6;
  e.nu_xy = 0.9;
  const StiffnessCheck together = check_orthotropic(e);
  e.nu_yz = e.nu_xz = 0.9;
  const StiffnessCheck check = check_orthotropic(e);
  ASSERT_EQ(check.violations.size(), 1u);
  EXPECT_NE(check.violations[0].admissible.find("xy in (-1, -0.62)"), std::string::npos)
      << check.violations[0].admissible;
  EXPECT_EQ(together.positive_definite(), together.least_scaled_eigenvalue > 0.0);
}

TEST(MatterFacts, WavesRunNoFasterThanTheBoundAndNoSlowerThanTheAxes) {
  const Mat6 iso = isotropic_stiffness(lame_moduli(1e5, 0.3));
  const LameModuli moduli = lame_moduli(1e5, 0.3);
  EXPECT_NEAR(stiffest_wave_modulus(iso), moduli.lambda + 2.0 * moduli.mu, 1e-6);
  const Mat6 C = matter_of(grains(Vec3::Ones(), 30.0)).stiffness;
  EXPECT_GE(stiffest_wave_modulus(C) * (1.0 + 1e-12), C.diagonal().head<3>().maxCoeff());
  EXPECT_LE(stiffest_wave_modulus(C), Eigen::SelfAdjointEigenSolver<Mat6>(C).eigenvalues()[5]);
}

// What the vectors do not cover.

TEST(MatterFacts, SnowCompactionIsFlooredAndClipped) {
  Material material;
  material.plasticity = Plasticity::snow;
  const Matter matter = matter_of(material);
  const auto after = [&](double stretch, double before) {
    return constitutive_step(matter, Vec3(stretch, 1, 1).asDiagonal(), Mat3::Identity(),
                             PlasticHistory{before, 0.0, 0.0})
        .history.volume_ratio;
  };
  EXPECT_NEAR(after(0.9, 1.0), 0.9 / 0.975, 1e-12);
  EXPECT_EQ(after(0.1, 0.5), 0.1);
  EXPECT_EQ(after(50.0, 5.0), 10.0);
  Vec3 e(-1.0, 0.0, 0.0); // Biot: a stretch of nothing counts as 1e-6
  Material biot = material;
  biot.elasticity = Elasticity::linear;
  PlasticHistory history;
  plastic_law(Plasticity::snow).project(e, history, {matter_of(biot)});
  EXPECT_EQ(history.volume_ratio, 0.1);
  history.volume_ratio = 1e6; // and the clip acts on what comes in
  e = Vec3(-0.5, 0.0, 0.0);
  plastic_law(Plasticity::snow).project(e, history, {matter_of(biot)});
  EXPECT_EQ(history.volume_ratio, 10.0);
}

TEST(MatterFacts, BiotStretchesAreClampedInStressAndDeformation) {
  Material material;
  material.elasticity = Elasticity::linear;
  material.poisson_ratio = {0, 0, 0};
  const ConstitutiveStep step =
      constitutive_step(matter_of(material), Vec3(0.01, 1, 1).asDiagonal(), Mat3::Identity(), {});
  EXPECT_NEAR(step.kirchhoff(0, 0), 1e5 * -0.99 * 0.05, 1e-6); // T as it is, its weight at the clamp
  EXPECT_EQ(step.F(0, 0), 0.01);                               // without yield F is F_trial
  std::vector<test::Sample> samples(1);
  material.plasticity = Plasticity::shear;
  material.plastic_scale = {1.0, 1.0, 1.1}; // anisotropic: the maps may leave the admissible stretches
  material.shear_limit = 1.9;
  const Matter matter = matter_of(material);
  const ConstitutiveStep flowed = constitutive_step(matter, Vec3(2.5, 0.02, 0.5).asDiagonal(), Mat3::Identity(), {});
  EXPECT_TRUE(flowed.yielded);
  EXPECT_GE(left_polar(flowed.F).stretches.minCoeff(), 0.05 - 1e-12);
}

/// The strains after isochoric flow with these weights, against plain flow.
std::pair<Vec3, Vec3> flows(const Vec3& strains, const Vec3& volume_per_strain) {
  Material material = grains(Vec3::Ones(), 30.0);
  material.flow = Flow::isochoric;
  const Matter isochoric = matter_of(material);
  material.flow = Flow::fictitious;
  const Matter plain = matter_of(material);
  Vec3 a = strains, b = strains;
  PlasticHistory one, other;
  plastic_law(Plasticity::drucker_prager).project(a, one, {isochoric, volume_per_strain});
  plastic_law(Plasticity::drucker_prager).project(b, other, {plain, volume_per_strain});
  EXPECT_EQ(one.flow, other.flow);
  return {a, b};
}

TEST(MatterFacts, IsochoricFlowKeepsTheVolumeOrFallsBack) {
  const Vec3 strains(-0.020, 0.002, 0.004), weights(1.2, 0.9, 0.9);
  const auto [kept, plain] = flows(strains, weights);
  EXPECT_NEAR(weights.dot(kept - strains), 0.0, 1e-15);
  EXPECT_GT(std::abs(weights.dot(plain - strains)), 1e-4);
  // The denominator is not positive; the step would overshoot the axis. (A trace above zero is a step above one: on the
  // cone the trace has the sign of what is left of the deviator.)
  for (const Vec3& hopeless : {Vec3(-9.0, 6.0, 6.0), Vec3(1.0, 6.4, 6.4)}) {
    const auto [fell_back, as_plain] = flows(strains, hopeless);
    EXPECT_EQ(fell_back, as_plain) << hopeless.transpose();
    EXPECT_NE(fell_back, strains);
  }
}

TEST(MatterFacts, VolumeCorrectionGivesBackWhatOpeningTook) {
  Material material;
  material.plasticity = Plasticity::drucker_prager;
  material.volume_correction = true;
  const Matter matter = matter_of(material);
  const ConstitutiveStep opened = constitutive_step(matter, 1.01 * Mat3::Identity(), Mat3::Identity(), {});
  EXPECT_NEAR(opened.history.volume_correction, 3.0 * std::log(1.01), 1e-12);
  EXPECT_LT((opened.F - Mat3::Identity()).norm(), 1e-12);
  // Pressed back together by as much, it carries nothing, and owes nothing.
  const ConstitutiveStep closed = constitutive_step(matter, opened.F / 1.01, Mat3::Identity(), opened.history);
  EXPECT_NEAR(closed.history.volume_correction, 0.0, 1e-12);
  EXPECT_LT(closed.kirchhoff.norm(), 1e-6);
  EXPECT_TRUE(closed.yielded); // v_c alone rewrites F
}

TEST(MatterFacts, TheSeriesOfTheConjugateWeightMeetsTheClosedForm) {
  // Around a difference of 1e-4 the reference changes from one to the other; stress is continuous to 1e-13.
  const Material material = [] {
    Material m = grains(Vec3::Ones(), 30.0);
    m.plasticity = Plasticity::none;
    return m;
  }();
  const Matter matter = matter_of(material);
  const Mat3 Q = rodrigues(Vec3(0.4, 0.2, -0.7));
  const auto stress = [&](double difference) {
    return constitutive_step(matter, exponential(Vec3(0.1, 0.1 + difference, 0.3).asDiagonal()), Q, {}).kirchhoff;
  };
  const Mat3 below = stress(0.99999e-4), above = stress(1.00001e-4);
  EXPECT_LT((above - below).norm(), 1e-8 * above.norm());
  const Mat3 slope_below = (stress(0.99999e-4) - stress(0.98e-4)) / (0.99999e-4 - 0.98e-4);
  const Mat3 slope_above = (stress(1.02e-4) - stress(1.00001e-4)) / (1.02e-4 - 1.00001e-4);
  EXPECT_LT((slope_above - slope_below).norm(), 1e-4 * slope_above.norm());
}

} // namespace
} // namespace wry::mpm
