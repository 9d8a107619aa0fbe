#include <cmath>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "tests/fem/kernel_support.h"

namespace wry::fem {
namespace {

constexpr int ELEMENTS = 11; // two batches, the second one padded
constexpr double STEP = 3e-4;

/// d value / d dof i of every element by a stencil of order 6.
template <class Evaluate> auto difference(KernelSample sample, int i, const Evaluate& evaluate_at) {
  const auto shifted = [&](double shift) {
    for (int element = 0; element < sample.group.element_count; ++element)
      sample.dof(element, i) += shift;
    auto values = evaluate_at(sample);
    for (int element = 0; element < sample.group.element_count; ++element)
      sample.dof(element, i) -= shift;
    return values;
  };
  constexpr double WEIGHTS[3] = {3.0 / 4.0, -3.0 / 20.0, 1.0 / 60.0};
  auto sum = shifted(STEP);
  for (auto& value : sum)
    value *= 0.0;
  for (int n = 0; n < 3; ++n) {
    const auto plus = shifted((n + 1) * STEP);
    const auto minus = shifted(-(n + 1) * STEP);
    for (std::size_t e = 0; e < sum.size(); ++e)
      sum[e] += WEIGHTS[n] / STEP * (plus[e] - minus[e]);
  }
  return sum;
}

class EveryKernel : public testing::TestWithParam<KernelCase> {};

TEST_P(EveryKernel, HasTheGradientOfItsEnergy) {
  const KernelSample sample = random_sample(GetParam(), ELEMENTS, 11);
  const ElementResults exact = evaluate(sample, native_isa());
  for (int i = 0; i < 4 * sample.group.dofs_per_node(); ++i) {
    const auto slope = difference(sample, i, [](const KernelSample& s) { return energies(s, native_isa()); });
    for (std::size_t e = 0; e < slope.size(); ++e)
      EXPECT_NEAR(slope[e], exact.gradient[e][i], 1e-8 * exact.gradient[e].cwiseAbs().maxCoeff()) << "dof " << i;
  }
}

TEST_P(EveryKernel, HasTheHessianOfItsGradient) {
  const KernelSample sample = random_sample(GetParam(), ELEMENTS, 12);
  const ElementResults exact = evaluate(sample, native_isa());
  for (int i = 0; i < 4 * sample.group.dofs_per_node(); ++i) {
    const auto column = difference(sample, i, [](const KernelSample& s) { return gradients(s, native_isa()); });
    for (std::size_t e = 0; e < column.size(); ++e) {
      const double scale = exact.hessian[e].cwiseAbs().maxCoeff();
      EXPECT_LE((column[e] - exact.hessian[e].col(i)).cwiseAbs().maxCoeff(), 1e-8 * scale) << "dof " << i;
    }
  }
}

TEST_P(EveryKernel, HasASymmetricHessian) {
  const ElementResults exact = evaluate(random_sample(GetParam(), ELEMENTS, 13), native_isa());
  for (const Eigen::MatrixXd& hessian : exact.hessian)
    EXPECT_LE((hessian - hessian.transpose()).cwiseAbs().maxCoeff(), 1e-14 * hessian.cwiseAbs().maxCoeff());
}

TEST_P(EveryKernel, GivesTheSameOnAllInstructionSets) {
  const KernelSample sample = random_sample(GetParam(), ELEMENTS, 14);
  const ElementResults wide = evaluate(sample, native_isa());
  for (const Isa isa : runnable_isas()) {
    const ElementResults narrow = evaluate(sample, isa);
    for (std::size_t e = 0; e < wide.energy.size(); ++e) {
      EXPECT_NEAR(narrow.energy[e], wide.energy[e], 1e-12 * std::abs(wide.energy[e])) << isa_name(isa);
      EXPECT_LE((narrow.gradient[e] - wide.gradient[e]).cwiseAbs().maxCoeff(),
                1e-12 * wide.gradient[e].cwiseAbs().maxCoeff())
          << isa_name(isa);
      EXPECT_LE((narrow.hessian[e] - wide.hessian[e]).cwiseAbs().maxCoeff(),
                1e-12 * wide.hessian[e].cwiseAbs().maxCoeff())
          << isa_name(isa);
    }
  }
}

TEST_P(EveryKernel, DoesNotFeelARotationOfEverything) {
  const KernelSample sample = random_sample(GetParam(), ELEMENTS, 15);
  std::mt19937 random(5);
  const Eigen::Vector4d turn = random_rotation(random);
  const Mat3 R = matrix_of(turn);
  KernelSample turned = sample;
  const auto turn_vectors = [&](std::vector<double>& field) {
    for (std::size_t i = 0; i < field.size(); i += 3)
      Eigen::Map<Vec3>(field.data() + i) = R * Vec3(Eigen::Map<Vec3>(field.data() + i));
  };
  turn_vectors(turned.positions);
  turn_vectors(turned.increments);
  for (std::size_t i = 0; i < turned.rotations.size(); i += 4) {
    Eigen::Map<Eigen::Vector4d> q(turned.rotations.data() + i);
    q = product(turn, q);
  }
  if (is_micropolar(GetParam().model)) {
    for (int element = 0; element < ELEMENTS; ++element) {
      for (int p = 0; p < POINTS; ++p) {
        Eigen::Vector4d q;
        for (int i = 0; i < 4; ++i)
          q[i] = group_entry(turned.group.point_rotations, element, 16, 4 * p + i);
        q = product(turn, q);
        for (int i = 0; i < 4; ++i)
          group_entry(turned.group.point_rotations, element, 16, 4 * p + i) = q[i];
      }
    }
  }
  const ElementResults before = evaluate(sample, native_isa());
  const ElementResults after = evaluate(turned, native_isa());
  const int size = 4 * sample.group.dofs_per_node();
  Eigen::MatrixXd Q = Eigen::MatrixXd::Zero(size, size);
  for (int i = 0; i < size; i += 3)
    Q.block<3, 3>(i, i) = R;
  for (std::size_t e = 0; e < before.energy.size(); ++e) {
    EXPECT_NEAR(after.energy[e], before.energy[e], 1e-12 * std::abs(before.energy[e]));
    EXPECT_LE((after.gradient[e] - Q * before.gradient[e]).cwiseAbs().maxCoeff(),
              1e-12 * before.gradient[e].cwiseAbs().maxCoeff());
    EXPECT_LE((after.hessian[e] - Q * before.hessian[e] * Q.transpose()).cwiseAbs().maxCoeff(),
              1e-12 * before.hessian[e].cwiseAbs().maxCoeff());
  }
}

INSTANTIATE_TEST_SUITE_P(Table, EveryKernel, testing::ValuesIn(all_kernel_cases()),
                         [](const testing::TestParamInfo<KernelCase>& listed) {
                           std::string name;
                           for (const char c : listed.param.name())
                             name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
                           return name;
                         });

} // namespace
} // namespace wry::fem
