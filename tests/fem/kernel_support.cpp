#include "tests/fem/kernel_support.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "sim/fem/kernels/kernel_table.h"

namespace wry::fem {

namespace {

const char* model_name(ElasticModel model) {
  switch (model) {
  case ElasticModel::neo_hookean:
    return "neo_hookean";
  case ElasticModel::neo_hookean_eq16:
    return "neo_hookean_eq16";
  case ElasticModel::stvk:
    return "stvk";
  case ElasticModel::corotated:
    return "corotated";
  case ElasticModel::micropolar:
    return "micropolar";
  case ElasticModel::micropolar_det:
    return "micropolar_det";
  case ElasticModel::micropolar_neo_hookean:
    return "micropolar_neo_hookean";
  }
  return "?";
}

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
}

Vec3 random_vector(std::mt19937& random, double size) {
  Vec3 v;
  for (int i = 0; i < 3; ++i)
    v[i] = uniform(random, -size, size);
  return v;
}

Mat3 random_matrix(std::mt19937& random, double size) {
  Mat3 m;
  for (int i = 0; i < 9; ++i)
    m(i / 3, i % 3) = uniform(random, -size, size);
  return m;
}

Mat3 random_deformation(std::mt19937& random) {
  for (;;) {
    const Mat3 F = matrix_of(random_rotation(random)) * (Mat3::Identity() + random_matrix(random, 0.5));
    if (F.determinant() > 0.4 && F.determinant() < 2.5)
      return F;
  }
}

void set_rotation(double* to, const Eigen::Vector4d& q) {
  std::copy(q.data(), q.data() + 4, to);
}

void fill_element(KernelSample& sample, int element, std::mt19937& random) {
  ElementGroup& group = sample.group;
  Mat3 edges;
  do
    edges = random_matrix(random, 1.0);
  while (edges.determinant() < 0.15);
  edges *= 0.3;
  const Mat3 gradients = edges.inverse();
  for (int i = 0; i < 9; ++i)
    group_entry(group.shape_gradients, element, 9, i) = gradients(i / 3, i % 3);
  group_entry(group.volume, element, 1, 0) = edges.determinant() / 6.0;
  const double mu = uniform(random, 0.5, 2.0);
  group_entry(group.mu, element, 1, 0) = mu;
  group_entry(group.lambda, element, 1, 0) = uniform(random, 0.2, 3.0);
  group_entry(group.mu_c, element, 1, 0) = group.couple_equals_shear ? mu : uniform(random, 0.1, 5.0);

  const Mat3 deformed = random_deformation(random) * edges;
  const Vec3 origin = random_vector(random, 0.2);
  const Eigen::Vector4d common = random_rotation(random);
  const auto nearby = [&] {
    Eigen::Vector4d q(1.0, 0.0, 0.0, 0.0);
    q.tail<3>() = random_vector(random, 0.4);
    return Eigen::Vector4d(product(q.normalized(), common));
  };
  for (int k = 0; k < 4; ++k) {
    const Vec3 x = origin + (k > 0 ? Vec3(deformed.col(k - 1)) : Vec3(Vec3::Zero()));
    const Vec3 a = random_vector(random, 0.9);
    const auto node = static_cast<std::size_t>(4 * element + k);
    std::copy(x.data(), x.data() + 3, sample.positions.data() + 3 * node);
    std::copy(a.data(), a.data() + 3, sample.increments.data() + 3 * node);
    set_rotation(sample.rotations.data() + 4 * node, nearby());
  }
  if (group.point_rotations.empty())
    return;
  for (int p = 0; p < POINTS; ++p) {
    const Eigen::Vector4d q = nearby();
    for (int i = 0; i < 4; ++i)
      group_entry(group.point_rotations, element, 16, 4 * p + i) = q[i];
  }
  const int moduli = static_cast<int>(group.curvature_moduli.size() / group.volume.size());
  for (int i = 0; i < moduli; ++i)
    group_entry(group.curvature_moduli, element, moduli, i) = uniform(random, 0.0, 0.2);
  if (!group.curvature_basis.empty()) {
    const Mat3 basis = matrix_of(random_rotation(random));
    for (int i = 0; i < 9; ++i)
      group_entry(group.curvature_basis, element, 9, i) = basis(i / 3, i % 3);
  }
  if (!group.rest_curvature.empty()) {
    for (int i = 0; i < 36; ++i)
      group_entry(group.rest_curvature, element, 36, i) = uniform(random, -2.0, 2.0);
  }
}

} // namespace

std::string KernelCase::name() const {
  std::string text = model_name(model);
  if (!is_micropolar(model))
    return text;
  text += couple_equals_shear ? ", mu_c = mu" : ", any mu_c";
  if (curvature == CurvatureModel::isotropic)
    text += ", isotropic";
  if (curvature == CurvatureModel::orthotropic)
    text += has_basis ? ", orthotropic with basis" : ", orthotropic";
  return text + (has_rest_curvature ? ", rest curvature" : "");
}

std::vector<KernelCase> all_kernel_cases() {
  std::vector<KernelCase> cases;
  for (const ElasticModel model : models_with_kernels()) {
    if (!is_micropolar(model)) {
      cases.push_back({.model = model});
      continue;
    }
    for (const bool equal : {true, false}) {
      cases.push_back({.model = model, .couple_equals_shear = equal});
      for (const bool rest : {false, true}) {
        cases.push_back({model, CurvatureModel::isotropic, equal, false, rest});
        cases.push_back({model, CurvatureModel::orthotropic, equal, false, rest});
        cases.push_back({model, CurvatureModel::orthotropic, equal, true, rest});
      }
    }
  }
  return cases;
}

double& KernelSample::dof(int element, int i) {
  const int dofs = group.dofs_per_node();
  const int node = 4 * element + i / dofs;
  const int component = i % dofs;
  return component < 3 ? positions[static_cast<std::size_t>(3 * node + component)]
                       : increments[static_cast<std::size_t>(3 * node + component - 3)];
}

double& group_entry(AlignedVector<double>& array, int element, int count, int i) {
  return array[static_cast<std::size_t>((element / LANES * count + i) * LANES + element % LANES)];
}

KernelSample empty_sample(const KernelCase& kernel_case, int element_count) {
  KernelSample sample;
  ElementGroup& group = sample.group;
  group.model = kernel_case.model;
  group.curvature = kernel_case.curvature;
  group.couple_equals_shear = kernel_case.couple_equals_shear;
  group.element_count = element_count;
  group.batch_count = (element_count + LANES - 1) / LANES;
  const auto lanes = static_cast<std::size_t>(group.batch_count * LANES);
  group.nodes.assign(4 * lanes, 0);
  for (int element = 0; element < static_cast<int>(lanes); ++element) {
    for (int k = 0; k < 4; ++k)
      group.nodes[static_cast<std::size_t>((element / LANES * 4 + k) * LANES + element % LANES)] =
          4 * std::min(element, element_count - 1) + k;
  }
  group.shape_gradients.assign(9 * lanes, 0.0);
  group.volume.assign(lanes, 0.0);
  group.mu.assign(lanes, 1.0);
  group.lambda.assign(lanes, 1.0);
  group.mu_c.assign(lanes, 1.0);
  const auto nodes = static_cast<std::size_t>(4 * element_count);
  sample.positions.assign(3 * nodes, 0.0);
  sample.increments.assign(3 * nodes, 0.0);
  sample.rotations.assign(4 * nodes, 0.0);
  if (!is_micropolar(kernel_case.model))
    return sample;
  group.point_rotations.assign(16 * lanes, 0.0);
  for (int element = 0; element < static_cast<int>(lanes); ++element) {
    for (int p = 0; p < POINTS; ++p)
      group_entry(group.point_rotations, element, 16, 4 * p) = 1.0;
  }
  if (kernel_case.curvature == CurvatureModel::none)
    return sample;
  group.curvature_moduli.assign((kernel_case.curvature == CurvatureModel::isotropic ? 3 : 9) * lanes, 0.1);
  if (kernel_case.has_basis)
    group.curvature_basis.assign(9 * lanes, 0.0);
  if (kernel_case.has_rest_curvature)
    group.rest_curvature.assign(36 * lanes, 0.0);
  return sample;
}

KernelSample random_sample(const KernelCase& kernel_case, int element_count, unsigned seed) {
  std::mt19937 random(seed);
  KernelSample sample = empty_sample(kernel_case, element_count);
  for (int element = 0; element < element_count; ++element)
    fill_element(sample, element, random);
  return sample;
}

namespace {

// Values that no kernel writes: they show what was left out.
constexpr double UNTOUCHED = -7.25e77;

std::unique_ptr<BatchDerivatives> untouched() {
  auto out = std::make_unique<BatchDerivatives>();
  std::fill(std::begin(out->energy), std::end(out->energy), UNTOUCHED);
  std::fill(std::begin(out->gradient), std::end(out->gradient), UNTOUCHED);
  std::fill(std::begin(out->hessian), std::end(out->hessian), UNTOUCHED);
  return out;
}

Eigen::VectorXd gradient_of(const BatchDerivatives& out, int lane, int size) {
  Eigen::VectorXd gradient(size);
  for (int i = 0; i < size; ++i)
    gradient[i] = out.gradient[i * LANES + lane];
  return gradient;
}

Eigen::MatrixXd hessian_of(const BatchDerivatives& out, int lane, int dofs) {
  Eigen::MatrixXd hessian(4 * dofs, 4 * dofs);
  int block = 0;
  for (int k = 0; k < 4; ++k) {
    for (int l = k; l < 4; ++l, ++block) {
      for (int i = 0; i < dofs; ++i) {
        for (int j = 0; j < dofs; ++j) {
          const double value = out.hessian[(block * dofs * dofs + i * dofs + j) * LANES + lane];
          hessian(k * dofs + i, l * dofs + j) = value;
          if (k != l)
            hessian(l * dofs + j, k * dofs + i) = value;
        }
      }
    }
  }
  return hessian;
}

} // namespace

ElementResults evaluate(const KernelSample& sample, Isa isa) {
  const ElementKernel kernel = select_kernel(sample.group, isa);
  const int dofs = sample.group.dofs_per_node();
  ElementResults results;
  for (int batch = 0; batch < sample.group.batch_count; ++batch) {
    const auto full = untouched();
    const auto slopes = untouched();
    alignas(64) double energy[LANES];
    kernel.hessian(sample.group, sample.fields(), batch, *full);
    kernel.gradient(sample.group, sample.fields(), batch, *slopes);
    kernel.energy(sample.group, sample.fields(), batch, energy);
    for (int lane = 0; lane < LANES; ++lane) {
      const Eigen::VectorXd gradient = gradient_of(*full, lane, 4 * dofs);
      const Eigen::MatrixXd hessian = hessian_of(*full, lane, dofs);
      if (batch * LANES + lane >= sample.group.element_count) {
        EXPECT_EQ(full->energy[lane], 0.0);
        EXPECT_EQ(slopes->energy[lane], 0.0);
        EXPECT_EQ(energy[lane], 0.0);
        EXPECT_EQ(gradient.cwiseAbs().maxCoeff(), 0.0);
        EXPECT_EQ(gradient_of(*slopes, lane, 4 * dofs).cwiseAbs().maxCoeff(), 0.0);
        EXPECT_EQ(hessian.cwiseAbs().maxCoeff(), 0.0);
        continue;
      }
      const double energy_scale = std::abs(energy[lane]) + 1e-3 * sample.group.volume[0];
      EXPECT_NEAR(full->energy[lane], energy[lane], 1e-13 * energy_scale);
      EXPECT_NEAR(slopes->energy[lane], energy[lane], 1e-13 * energy_scale);
      EXPECT_LE((gradient_of(*slopes, lane, 4 * dofs) - gradient).cwiseAbs().maxCoeff(),
                1e-12 * (1e-3 + gradient.cwiseAbs().maxCoeff()));
      results.energy.push_back(full->energy[lane]);
      results.gradient.push_back(gradient);
      results.hessian.push_back(hessian);
    }
  }
  return results;
}

std::vector<double> energies(const KernelSample& sample, Isa isa) {
  const ElementKernel kernel = select_kernel(sample.group, isa);
  std::vector<double> values;
  alignas(64) double energy[LANES];
  for (int batch = 0; batch < sample.group.batch_count; ++batch) {
    kernel.energy(sample.group, sample.fields(), batch, energy);
    values.insert(values.end(), energy, energy + LANES);
  }
  values.resize(static_cast<std::size_t>(sample.group.element_count));
  return values;
}

std::vector<Eigen::VectorXd> gradients(const KernelSample& sample, Isa isa) {
  const ElementKernel kernel = select_kernel(sample.group, isa);
  std::vector<Eigen::VectorXd> values;
  for (int batch = 0; batch < sample.group.batch_count; ++batch) {
    const auto out = untouched();
    kernel.gradient(sample.group, sample.fields(), batch, *out);
    for (int lane = 0; lane < LANES && batch * LANES + lane < sample.group.element_count; ++lane)
      values.push_back(gradient_of(*out, lane, 4 * sample.group.dofs_per_node()));
  }
  return values;
}

Eigen::Vector4d random_rotation(std::mt19937& random) {
  for (;;) {
    Eigen::Vector4d q;
    for (int i = 0; i < 4; ++i)
      q[i] = uniform(random, -1.0, 1.0);
    if (q.norm() > 0.1 && q.norm() < 1.0)
      return q.normalized();
  }
}

Mat3 matrix_of(const Eigen::Vector4d& q) {
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
}

Eigen::Vector4d product(const Eigen::Vector4d& a, const Eigen::Vector4d& b) {
  const Eigen::Quaterniond q = Eigen::Quaterniond(a[0], a[1], a[2], a[3]) * Eigen::Quaterniond(b[0], b[1], b[2], b[3]);
  return {q.w(), q.x(), q.y(), q.z()};
}

} // namespace wry::fem
