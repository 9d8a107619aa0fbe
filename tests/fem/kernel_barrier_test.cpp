#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/fem/kernel_support.h"

namespace wry::fem {
namespace {

bool has_barrier(ElasticModel model) {
  return model == ElasticModel::neo_hookean || model == ElasticModel::neo_hookean_eq16 ||
         model == ElasticModel::micropolar_det || model == ElasticModel::micropolar_neo_hookean;
}

TEST(KernelBarrier, EnergyOfInvertedAndFlatElementsIsInfiniteAndOfTheOthersFinite) {
  for (const KernelCase& kernel_case : all_kernel_cases()) {
    KernelSample sample = random_sample(kernel_case, 11, 21);
    const auto mirror = [&](int element, double factor) {
      for (std::size_t k = 0; k < 4; ++k)
        sample.positions[3 * (4 * static_cast<std::size_t>(element) + k)] *= factor;
    };
    mirror(2, -1.0);
    mirror(5, 0.0);
    mirror(10, -1.0); // its nodes are those of the padding lanes
    for (const Isa isa : runnable_isas()) {
      const std::vector<double> energy = energies(sample, isa);
      const ElementResults all = evaluate(random_sample(kernel_case, 11, 21), isa);
      for (std::size_t e = 0; e < energy.size(); ++e) {
        if (has_barrier(kernel_case.model) && (e == 2 || e == 5 || e == 10))
          EXPECT_EQ(energy[e], std::numeric_limits<double>::infinity()) << kernel_case.name();
        else
          EXPECT_TRUE(std::isfinite(energy[e])) << kernel_case.name();
        EXPECT_TRUE(all.hessian[e].allFinite());
      }
      alignas(64) double padded[LANES];
      select_kernel(sample.group, isa).energy(sample.group, sample.fields(), 1, padded);
      for (int lane = 3; lane < LANES; ++lane)
        EXPECT_EQ(padded[lane], 0.0) << kernel_case.name();
    }
  }
}

TEST(KernelBarrier, SmallStrainsKeepTheDigitsOfTheEnergy) {
  // Along F = I + e diag(1, -1, 0) neo-Hookean energies are 2 mu e^2 + O(e^3) per volume, far below the rounding of mu.
  for (const ElasticModel model : {ElasticModel::neo_hookean, ElasticModel::neo_hookean_eq16}) {
    KernelSample sample = empty_sample({.model = model}, 1);
    group_entry(sample.group.volume, 0, 1, 0) = 1.0 / 6.0;
    const double e = std::ldexp(1.0, -30);
    for (int k = 0; k < 3; ++k) {
      group_entry(sample.group.shape_gradients, 0, 9, 4 * k) = 1.0;
      sample.positions[static_cast<std::size_t>(3 * (k + 1) + k)] = 1.0 + (k == 0 ? e : k == 1 ? -e : 0.0);
    }
    for (const Isa isa : runnable_isas())
      EXPECT_NEAR(energies(sample, isa)[0] / (2.0 * e * e / 6.0), 1.0, 1e-8) << isa_name(isa);
  }
}

} // namespace
} // namespace wry::fem
