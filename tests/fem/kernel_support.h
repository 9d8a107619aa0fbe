#pragma once

#include <random>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "sim/fem/element_kernels.h"
#include "tests/runnable_isas.h"

namespace wry::fem {

/// One way of calling a kernel.
struct KernelCase {
  ElasticModel model = ElasticModel::neo_hookean;
  CurvatureModel curvature = CurvatureModel::none;
  bool couple_equals_shear = false;
  bool has_basis = false;
  bool has_rest_curvature = false;

  std::string name() const;
};

/// Every model of the table with every curvature, basis and couple modulus that it can have.
std::vector<KernelCase> all_kernel_cases();

using test::runnable_isas;

/// Elements with fields of their own: element e owns nodes 4 e .. 4 e + 3.
struct KernelSample {
  ElementGroup group;
  std::vector<double> positions, increments, rotations;

  NodeFields fields() const { return {positions.data(), increments.data(), rotations.data()}; }
  /// Entry of dof i (node-major, as in BatchDerivatives) of an element.
  double& dof(int element, int i);
};

/// A group without elements' data, of the right sizes, padding lanes as build_element_group makes them.
KernelSample empty_sample(const KernelCase& kernel_case, int element_count);

/// Entry i of an array of a group with `count` entries per element.
double& group_entry(AlignedVector<double>& array, int element, int count, int i);

/// Random tets, deformations with det F in about [.4, 2.5], rotations, moduli. Deterministic.
KernelSample random_sample(const KernelCase& kernel_case, int element_count, unsigned seed);

/// Energy, gradient and Hessian of each element by one kernel.
struct ElementResults {
  std::vector<double> energy;
  std::vector<Eigen::VectorXd> gradient;
  std::vector<Eigen::MatrixXd> hessian;
};

/// Evaluates energy(), gradient() and hessian() and fails the test if they do not agree with each other, or if a
/// padding lane is not exactly zero.
ElementResults evaluate(const KernelSample& sample, Isa isa);
/// Energies alone, padding lanes left out.
std::vector<double> energies(const KernelSample& sample, Isa isa);
/// Gradients alone.
std::vector<Eigen::VectorXd> gradients(const KernelSample& sample, Isa isa);

/// A random unit quaternion (w, x, y, z).
Eigen::Vector4d random_rotation(std::mt19937& random);
/// Rotation matrix and product of quaternions (w, x, y, z), written apart from the code under test.
Mat3 matrix_of(const Eigen::Vector4d& q);
Eigen::Vector4d product(const Eigen::Vector4d& a, const Eigen::Vector4d& b);

} // namespace wry::fem
