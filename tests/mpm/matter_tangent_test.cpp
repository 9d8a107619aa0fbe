#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "sim/mpm/matter/kernels/matter_kernels.h"
#include "tests/mpm/matter_tiles_support.h"

namespace wry::mpm {
namespace {

constexpr int COMPONENT[3][3] = {{0, 5, 4}, {5, 1, 3}, {4, 3, 2}};

Material orthotropic() {
  Material material;
  material.name = "card";
  material.youngs_modulus = {2e5, 3e5, 5e6};
  material.poisson_ratio.yz = 0.05;
  material.poisson_ratio.xz = 0.03;
  material.poisson_ratio.xy = 0.2;
  return material;
}

/// sigma of the frozen material for a rate of strain, the particle standing in a frame.
Mat3 tangent_stress(const Material& material, Isa isa, const Mat3& rate, const Eigen::Quaterniond& frame) {
  constexpr int W = TILE_WIDTH<double>;
  const auto compiled = compile_material(material);
  EXPECT_TRUE(compiled);
  const MaterialConstants<double> constants = constants_in<double>(compiled->constants);
  const MaterialKernels<double> kernels = find_material_kernels<double>(material, *compiled, isa);
  std::vector<AlignedVector<double>> state(CHANNEL_COUNT);
  AlignedVector<double> F(9 * W), frozen(static_cast<std::size_t>(kernels.tangent.components) * W), D(6 * W);
  ConstitutiveTiles<double> tiles;
  tiles.count = 1;
  tiles.deformation = F.data();
  for (const Channel channel : compiled->channels) {
    AlignedVector<double>& values = state[static_cast<std::size_t>(channel)];
    values.assign(static_cast<std::size_t>(channel_info(channel).components) * W, channel_info(channel).initial);
    tiles.state[static_cast<int>(channel)] = values.data();
  }
  for (int lane = 0; lane < W; ++lane) {
    const double q[4] = {frame.w(), frame.x(), frame.y(), frame.z()};
    for (int i = 0; i < 4 && tiles.of(Channel::frame) != nullptr; ++i)
      tiles.of(Channel::frame)[i * W + lane] = q[i];
    for (int i = 0; i < 3; ++i) {
      F[static_cast<std::size_t>(4 * i * W + lane)] = 1.0;
      if (tiles.of(Channel::second_moment) != nullptr)
        tiles.of(Channel::second_moment)[i * W + lane] = 1.0 / 3.0;
      for (int j = i; j < 3; ++j)
        D[static_cast<std::size_t>(COMPONENT[i][j] * W + lane)] = rate(i, j);
    }
  }
  kernels.tangent.freeze(constants, tiles, frozen.data());
  kernels.tangent.stress(constants, frozen.data(), D.data());
  Mat3 stress;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      stress(i, j) = D[static_cast<std::size_t>(COMPONENT[i][j] * W)];
  }
  return stress;
}

TEST(Tangent, IsTheStressOfASmallStrainOfEveryKindOfMatter) {
  Material isotropic;
  Material general = orthotropic();
  general.name = "general";
  general.plasticity = Plasticity::shear; // which has maps, and does not yield here
  general.shear_limit = 1.0;
  Mat3 map;
  map << 1, 0.1, 0, 0.05, 0.9, 0, 0, 0.1, 1.1;
  general.plastic_map = map;
  Material cards = orthotropic();
  cards.name = "cards";
  cards.plasticity = Plasticity::shear;
  cards.shear_limit = 1.0;
  Material grains = orthotropic();
  grains.name = "grains";
  grains.reorientation = Reorientation{};
  grains.reorientation->isotropic = {1e5, 0.2, 1.0};
  grains.reorientation->parallel = {4e5, 0.1, 1.0};
  grains.reorientation->perpendicular = {5e4, 0.3, 1.0};
  const Eigen::Quaterniond frame(Eigen::AngleAxisd(2.9, Vec3(1, -2, 0.5).normalized()));
  Mat3 rate;
  rate << -0.9, 0.2, 0.1, 0.2, -1.1, -0.15, 0.1, -0.15, -1.0;
  for (const Isa isa : test::runnable_isas()) {
    for (const Material& material : {isotropic, orthotropic(), general, cards, grains}) {
      constexpr double DT = 1e-7;
      std::vector<test::Sample> one(1);
      one[0].L = rate;
      one[0].frame = Vec4(frame.w(), frame.x(), frame.y(), frame.z());
      test::run_kernel<double>(material, isa, DT, one);
      const Mat3 expected = one[0].tau / DT;
      EXPECT_LT((tangent_stress(material, isa, rate, frame) - expected).norm(), 1e-5 * expected.norm())
          << material.name << " " << isa_name(isa);
    }
  }
}

TEST(Tangent, GrowsWithCompactedSnow) {
  Material snow;
  snow.plasticity = Plasticity::snow;
  const auto compiled = compile_material(snow);
  ASSERT_TRUE(compiled);
  constexpr int W = TILE_WIDTH<double>;
  AlignedVector<double> F(9 * W, 0.0), volume(W, 0.9), frozen(W, 0.0), D(6 * W, 0.0);
  ConstitutiveTiles<double> tiles;
  tiles.count = 1;
  tiles.deformation = F.data();
  tiles.state[static_cast<int>(Channel::plastic_volume)] = volume.data();
  const MaterialConstants<double> constants = constants_in<double>(compiled->constants);
  const TangentKernel<double> tangent = find_material_kernels<double>(snow, *compiled, native_isa()).tangent;
  ASSERT_EQ(tangent.components, FROZEN_FACTOR);
  tangent.freeze(constants, tiles, frozen.data());
  EXPECT_NEAR(frozen[0], std::exp(snow.snow_hardening * 0.1), 1e-12);
}

} // namespace
} // namespace wry::mpm
