#include <algorithm>
#include <cmath>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "sim/base/rotation.h"
#include "tests/fem/kernel_support.h"
#include "tests/fem/micropolar_support.h"

namespace wry::fem {
namespace {

using test::record_number;

Vec4 point_rotation(KernelSample& sample, int element, int p) {
  Vec4 q;
  for (int i = 0; i < 4; ++i)
    q[i] = group_entry(sample.group.point_rotations, element, 16, 4 * p + i);
  return q;
}

Vec4 node_rotation(const KernelSample& sample, int node) {
  return Eigen::Map<const Vec4>(sample.rotations.data() + 4 * node);
}

/// The sample without increments.
KernelSample at_rest(KernelSample sample) {
  std::fill(sample.increments.begin(), sample.increments.end(), 0.0);
  return sample;
}

TEST(KernelRigid, TheSameIncrementOfAllNodesAndATurnOfThePositionsCostNothing) {
  const Vec3 a(0.9, -0.4, 1.1);
  const Mat3 turn = rotation_matrix(cayley_update(identity_quaternion(), a));
  double worst = 0.0;
  for (const KernelCase& kernel_case : all_kernel_cases()) {
    const KernelSample start = at_rest(random_sample(kernel_case, 11, 31));
    KernelSample turned = start;
    for (std::size_t i = 0; i < turned.positions.size(); i += 3) {
      Eigen::Map<Vec3>(turned.positions.data() + i) = turn * Vec3(Eigen::Map<Vec3>(turned.positions.data() + i));
      Eigen::Map<Vec3>(turned.increments.data() + i) = a;
    }
    for (const Isa isa : runnable_isas()) {
      const std::vector<double> before = energies(start, isa), after = energies(turned, isa);
      for (std::size_t e = 0; e < before.size(); ++e) {
        EXPECT_NEAR(after[e], before[e], 1e-13 * std::abs(before[e])) << kernel_case.name() << " " << isa_name(isa);
        worst = std::max(worst, std::abs(after[e] / before[e] - 1.0));
      }
    }
  }
  record_number("turn of a whole element: change of energy (at most)", 1e-12, worst);
}

TEST(KernelRigid, AdvancingTheHistoryKeepsTheEnergyAndClearsTheIncrement) {
  for (const KernelCase& kernel_case : all_kernel_cases()) {
    if (!is_micropolar(kernel_case.model)) {
      EXPECT_EQ(select_kernel(random_sample(kernel_case, 1, 1).group, native_isa()).advance_rotations, nullptr);
      continue;
    }
    for (const Isa isa : runnable_isas()) {
      const KernelSample trial = random_sample(kernel_case, 11, 32);
      KernelSample advanced = trial;
      for (int batch = 0; batch < advanced.group.batch_count; ++batch)
        select_kernel(advanced.group, isa).advance_rotations(advanced.group, trial.fields(), batch);
      for (int node = 0; node < 44; ++node) {
        const Vec3 a = Eigen::Map<const Vec3>(trial.increments.data() + 3 * node);
        Eigen::Map<Vec4>(advanced.rotations.data() + 4 * node) = cayley_update(node_rotation(trial, node), a);
      }
      advanced = at_rest(advanced);
      const std::vector<double> before = energies(trial, isa), after = energies(advanced, isa);
      for (std::size_t e = 0; e < before.size(); ++e)
        EXPECT_NEAR(after[e], before[e], 1e-13 * std::abs(before[e])) << kernel_case.name() << " " << isa_name(isa);
    }
  }
}

TEST(KernelRigid, PointRotationsAdvanceByTheInterpolatedIncrement) {
  constexpr double NEAR = 0.5854101966249685, FAR = 0.1381966011250105;
  KernelSample sample = random_sample({.model = ElasticModel::micropolar}, 11, 33);
  KernelSample advanced = sample;
  for (int batch = 0; batch < 2; ++batch)
    select_kernel(advanced.group, native_isa()).advance_rotations(advanced.group, sample.fields(), batch);
  for (int element = 0; element < 11; ++element) {
    for (int p = 0; p < POINTS; ++p) {
      Vec3 a = Vec3::Zero();
      for (int k = 0; k < 4; ++k)
        a += (k == p ? NEAR : FAR) * Eigen::Map<const Vec3>(sample.increments.data() + 3 * (4 * element + k));
      const Vec4 expected = cayley_update(point_rotation(sample, element, p), a);
      EXPECT_LE((point_rotation(advanced, element, p) - expected).cwiseAbs().maxCoeff(), 1e-15);
    }
  }
}

TEST(KernelRigid, NegatingAllRotationsChangesNothing) {
  for (const KernelCase& kernel_case : all_kernel_cases()) {
    const KernelSample sample = random_sample(kernel_case, 11, 34);
    KernelSample negated = sample;
    for (double& value : negated.rotations)
      value = -value;
    for (double& value : negated.group.point_rotations)
      value = -value;
    const ElementResults before = evaluate(sample, native_isa()), after = evaluate(negated, native_isa());
    for (std::size_t e = 0; e < before.energy.size(); ++e) {
      EXPECT_EQ(after.energy[e], before.energy[e]) << kernel_case.name();
      EXPECT_EQ(after.gradient[e], before.gradient[e]) << kernel_case.name();
    }
  }
}

TEST(KernelRigid, PolarRotationsAreCriticalForTheMicropolarEnergy) {
  // Spec §4: the polar factor of F is a critical point of eq 11 in the rotations, whatever the moduli.
  for (const bool equal : {true, false}) {
    const KernelCase kernel_case{.model = ElasticModel::micropolar, .couple_equals_shear = equal};
    KernelSample sample = at_rest(random_sample(kernel_case, 11, 35));
    for (int element = 0; element < 11; ++element) {
      Mat3 edges, gradients;
      for (int k = 0; k < 3; ++k)
        edges.col(k) = Eigen::Map<Vec3>(sample.positions.data() + 3 * (4 * element + k + 1)) -
                       Eigen::Map<Vec3>(sample.positions.data() + 3 * (4 * element));
      for (int i = 0; i < 9; ++i)
        gradients(i / 3, i % 3) = group_entry(sample.group.shape_gradients, element, 9, i);
      const Vec4 q = quaternion_of(polar_rotation(edges * gradients));
      for (int p = 0; p < POINTS; ++p) {
        for (int i = 0; i < 4; ++i)
          group_entry(sample.group.point_rotations, element, 16, 4 * p + i) = q[i];
      }
    }
    const auto slopes = gradients(sample, native_isa());
    for (const Eigen::VectorXd& slope : slopes) {
      for (int k = 0; k < 4; ++k)
        EXPECT_LE(slope.segment<3>(6 * k + 3).norm(), 1e-13 * (1.0 + slope.norm()));
    }
  }
}

} // namespace
} // namespace wry::fem
