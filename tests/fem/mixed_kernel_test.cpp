#include <algorithm>
#include <cmath>
#include <memory>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "sim/base/rotation.h"
#include "sim/fem/kernels/mixed_table.h"
#include "sim/fem/mixed_group.h"
#include "sim/fem/mixed_term.h"
#include "tests/fem/kernel_support.h"
#include "tests/fem/solid_support.h"
#include "tests/vector_files.h"

namespace wry::fem {
namespace {

using nlohmann::json;

constexpr ElementKind KINDS[] = {ElementKind::tet4_one_point, ElementKind::tet10, ElementKind::plate3,
                                 ElementKind::plate6};

const char* name_of(ElementKind kind) {
  constexpr const char* NAMES[] = {"tet4", "tet4_one_point", "tet10", "plate3", "plate6"};
  return NAMES[static_cast<int>(kind)];
}

struct Case {
  ElementKind kind;
  CurvatureModel curvature = CurvatureModel::none;
  double couple = 1.0; ///< mu_c / mu
  bool basis = false, rest = false, limit = false;

  std::string name() const {
    return fmt::format("{} curvature {} mu_c/mu {} basis {} rest {} limit {}", name_of(kind),
                       static_cast<int>(curvature), couple, basis, rest, limit);
  }
};

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const ElementKind kind : KINDS) {
    for (const double couple : {1.0, 0.3}) {
      cases.push_back({kind, CurvatureModel::none, couple});
      cases.push_back({kind, CurvatureModel::isotropic, couple, false, true});
      if (is_plate(kind)) {
        cases.push_back({kind, CurvatureModel::isotropic, couple, false, true, true});
      } else {
        cases.push_back({kind, CurvatureModel::orthotropic, couple, false, true});
        cases.push_back({kind, CurvatureModel::orthotropic, couple, true, true});
      }
    }
  }
  return cases;
}

/// Elements with random rest shapes, deformations and rotations; element e owns nodes NX e ...
struct Sample {
  MixedGroup group;
  std::vector<double> positions, increments, rotations;
  int count = 0;

  NodeFields fields() const { return {positions.data(), increments.data(), rotations.data()}; }
  int unknowns() const { return 3 * (group.kernel->nodes + group.kernel->corners); }
  double& unknown(int element, int i) {
    const int node = i / 3 < group.kernel->nodes ? i / 3 : i / 3 - group.kernel->nodes;
    std::vector<double>& field = i / 3 < group.kernel->nodes ? positions : increments;
    return field[static_cast<std::size_t>(3 * (group.kernel->nodes * element + node) + i % 3)];
  }
};

Sample random_sample(const Case& c, Isa isa, int count, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  const auto vector = [&](double size) {
    return Vec3(uniform(-size, size), uniform(-size, size), uniform(-size, size));
  };
  FemBody body;
  body.name = "sample";
  body.element = c.kind;
  body.thickness = 0.05;
  body.material.model = ElasticModel::micropolar;
  body.material.youngs_modulus = 2.0;
  body.material.poisson_ratio = 0.3;
  body.material.couple_modulus_ratio = c.couple;
  body.material.length_scale = c.curvature == CurvatureModel::none ? 0.0 : 0.1;
  body.material.plate_bending = PlateBending::curv;
  body.material.curvature = c.curvature;
  body.material.alpha = 1.3;
  body.material.beta = 0.4;
  body.material.gamma = 0.7;
  if (c.limit)
    body.material.max_stretch = 1.05;
  for (int i = 0; i < 9; ++i)
    body.material.curvature_stiffness(i / 3, i % 3) = 0.2 + 0.3 * i;
  if (c.basis)
    body.material.curvature_basis = rodrigues(Vec3(0.4, -0.9, 0.3));
  const MixedKernel& kernel = *find_mixed_kernel(c.kind, isa);
  std::vector<std::int32_t> elements;
  Points vertices(count * kernel.nodes, 3);
  Sample sample;
  sample.count = count;
  sample.positions.resize(static_cast<std::size_t>(3 * count * kernel.nodes));
  sample.increments = sample.positions;
  sample.rotations.resize(static_cast<std::size_t>(4 * count * kernel.nodes));
  for (int element = 0; element < count; ++element) {
    const int first = element * kernel.nodes;
    Mat3 edges;
    do
      edges = (Mat3() << vector(1.0), vector(1.0), vector(1.0)).finished();
    while (edges.determinant() < 0.25);
    const Vec3 origin = vector(0.2);
    const Mat3 deformation =
        rodrigues(vector(1.5)) * (Mat3::Identity() + (Mat3() << vector(0.3), vector(0.3), vector(0.3)).finished());
    const Vec4 common = quaternion_exponential(vector(1.0));
    for (int k = 0; k < kernel.nodes; ++k) {
      elements.push_back(first + k);
      Vec3 place = origin;
      if (k < kernel.corners && k > 0)
        place += 0.3 * edges.col(k - 1);
      for (int i = 0, edge = kernel.corners; k >= kernel.corners && i < kernel.corners; ++i) {
        for (int j = i + 1; j < kernel.corners; ++j, ++edge) {
          if (edge == k)
            place = 0.5 * (vertices.row(first + i) + vertices.row(first + j)).transpose();
        }
      }
      vertices.row(first + k) = place.transpose();
      const Vec3 x = deformation * place + vector(0.01), a = vector(0.4);
      const Vec4 q = quaternion_product(quaternion_exponential(vector(0.2)), common);
      for (int i = 0; i < 3; ++i) {
        sample.positions[static_cast<std::size_t>(3 * (first + k) + i)] = x[i];
        sample.increments[static_cast<std::size_t>(3 * (first + k) + i)] = a[i];
      }
      std::copy_n(q.data(), 4, sample.rotations.begin() + 4 * (first + k));
    }
  }
  Result<MixedGroup> group = build_mixed_group(body, elements, vertices, 0, isa);
  EXPECT_TRUE(group) << (group ? "" : group.error().message);
  sample.group = std::move(*group);
  if (c.rest)
    sample.group.rest_curvature.assign(sample.group.volume.size() * 9 * static_cast<std::size_t>(kernel.points), 0.0);
  for (int element = 0; element < count; ++element) {
    for (int p = 0; p < kernel.points; ++p) {
      const Vec4 node(sample.rotations.data() + 4 * element * kernel.nodes);
      const Vec4 q = quaternion_product(quaternion_exponential(vector(0.1)), node);
      for (int i = 0; i < 4; ++i)
        group_entry(sample.group.point_rotations, element, 4 * kernel.points, 4 * p + i) = q[i];
      for (int i = 0; c.rest && i < 9; ++i)
        group_entry(sample.group.rest_curvature, element, 9 * kernel.points, 9 * p + i) = uniform(-1.0, 1.0);
    }
  }
  return sample;
}

using Evaluation = std::unique_ptr<MixedDerivatives>;

Evaluation evaluate(const Sample& sample, int batch, EvaluateMixed function) {
  Evaluation out = std::make_unique<MixedDerivatives>();
  function(sample.group.batch(batch), sample.fields(), *out);
  return out;
}

Eigen::VectorXd gradient_of(const Sample& sample, const MixedDerivatives& d, int lane) {
  Eigen::VectorXd gradient(sample.unknowns());
  for (int i = 0; i < gradient.size(); ++i)
    gradient[i] = d.gradient[i * LANES + lane];
  return gradient;
}

Eigen::MatrixXd hessian_of(const Sample& sample, const MixedDerivatives& d, int lane) {
  const int nodes = sample.group.kernel->nodes, corners = sample.group.kernel->corners;
  Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(sample.unknowns(), sample.unknowns());
  const auto set = [&](const double* block, int row, int column) {
    for (int i = 0; i < 9; ++i)
      hessian(row + i / 3, column + i % 3) = hessian(column + i % 3, row + i / 3) = block[i * LANES + lane];
  };
  for (int k = 0; k < nodes; ++k) {
    for (int l = k; l < nodes; ++l)
      set(d.xx + 9 * upper_block(k, l, nodes) * LANES, 3 * k, 3 * l);
    for (int l = 0; l < corners; ++l)
      set(d.xa + 9 * (k * corners + l) * LANES, 3 * k, 3 * (nodes + l));
  }
  for (int k = 0; k < corners; ++k) {
    for (int l = k; l < corners; ++l)
      set(d.aa + 9 * upper_block(k, l, corners) * LANES, 3 * (nodes + k), 3 * (nodes + l));
  }
  return hessian;
}

TEST(MixedKernels, DerivativesAreThoseOfTheEnergy) {
  double worst_gradient = 0.0, worst_hessian = 0.0;
  for (const Case& c : all_cases()) {
    for (const Isa isa : runnable_isas()) {
      Sample sample = random_sample(c, isa, 3, 7u);
      const MixedKernel& kernel = *sample.group.kernel;
      const Evaluation at = evaluate(sample, 0, kernel.hessian);
      const Evaluation slopes = evaluate(sample, 0, kernel.gradient);
      const Evaluation energy = evaluate(sample, 0, kernel.energy);
      for (int element = 0; element < sample.count; ++element) {
        SCOPED_TRACE(c.name() + " " + std::string(isa_name(isa)));
        EXPECT_NEAR(at->energy[element], energy->energy[element], 1e-13 * std::abs(energy->energy[element]));
        const Eigen::VectorXd gradient = gradient_of(sample, *at, element);
        const Eigen::MatrixXd hessian = hessian_of(sample, *at, element);
        EXPECT_LE((gradient_of(sample, *slopes, element) - gradient).cwiseAbs().maxCoeff(),
                  1e-12 * gradient.cwiseAbs().maxCoeff());
        constexpr double STEP = 1e-5;
        Eigen::VectorXd difference(gradient.size());
        Eigen::MatrixXd differences(gradient.size(), gradient.size());
        for (int i = 0; i < gradient.size(); ++i) {
          const double kept = sample.unknown(element, i);
          const auto apart = [&](double steps) { // difference over twice that many steps
            sample.unknown(element, i) = kept + steps * STEP;
            const Evaluation high = evaluate(sample, 0, kernel.gradient);
            sample.unknown(element, i) = kept - steps * STEP;
            const Evaluation low = evaluate(sample, 0, kernel.gradient);
            sample.unknown(element, i) = kept;
            const Eigen::VectorXd slope = gradient_of(sample, *high, element) - gradient_of(sample, *low, element);
            return std::pair((high->energy[element] - low->energy[element]) / (2.0 * steps * STEP),
                             Eigen::VectorXd(slope / (2.0 * steps * STEP)));
          };
          // Of fourth order: the limit of stretch has large third derivatives.
          const auto [near, near_slope] = apart(1.0);
          const auto [far, far_slope] = apart(2.0);
          difference[i] = (4.0 * near - far) / 3.0;
          differences.col(i) = (4.0 * near_slope - far_slope) / 3.0;
        }
        const double gradient_error = (difference - gradient).cwiseAbs().maxCoeff() / gradient.cwiseAbs().maxCoeff();
        const double hessian_error = (differences - hessian).cwiseAbs().maxCoeff() / hessian.cwiseAbs().maxCoeff();
        EXPECT_LE(gradient_error, 2e-8);
        EXPECT_LE(hessian_error, 2e-7);
        worst_gradient = std::max(worst_gradient, gradient_error);
        worst_hessian = std::max(worst_hessian, hessian_error);
      }
    }
  }
  std::printf("worst relative difference: gradient %.2g, Hessian %.2g\n", worst_gradient, worst_hessian);
}

TEST(MixedKernels, SuperposedRotationsChangeNoEnergy) {
  for (const Case& c : all_cases()) {
    Sample sample = random_sample(c, native_isa(), 8, 11u);
    const MixedKernel& kernel = *sample.group.kernel;
    const Evaluation before = evaluate(sample, 0, kernel.energy);
    const Vec4 turn = quaternion_exponential(Vec3(0.9, -1.7, 0.4));
    const Mat3 R = rotation_matrix(turn);
    const auto turn_vectors = [&](std::vector<double>& field) {
      for (std::size_t i = 0; i < field.size(); i += 3)
        Eigen::Map<Vec3>(field.data() + i) = (R * Eigen::Map<const Vec3>(field.data() + i)).eval();
    };
    turn_vectors(sample.positions);
    turn_vectors(sample.increments);
    for (std::size_t i = 0; i < sample.rotations.size(); i += 4)
      Eigen::Map<Vec4>(sample.rotations.data() + i) = quaternion_product(turn, Vec4(sample.rotations.data() + i));
    for (int element = 0; element < sample.count; ++element) {
      for (int p = 0; p < kernel.points; ++p) {
        Vec4 q;
        for (int i = 0; i < 4; ++i)
          q[i] = group_entry(sample.group.point_rotations, element, 4 * kernel.points, 4 * p + i);
        q = quaternion_product(turn, q);
        for (int i = 0; i < 4; ++i)
          group_entry(sample.group.point_rotations, element, 4 * kernel.points, 4 * p + i) = q[i];
      }
    }
    const Evaluation after = evaluate(sample, 0, kernel.energy);
    for (int element = 0; element < sample.count; ++element)
      EXPECT_NEAR(after->energy[element] / before->energy[element], 1.0, 1e-12) << c.name();
  }
}

TEST(MixedKernels, PaddingLanesAreZero) {
  for (const Case& c : all_cases()) {
    const Sample sample = random_sample(c, native_isa(), 3, 3u);
    const Evaluation at = evaluate(sample, 0, sample.group.kernel->hessian);
    for (int lane = 3; lane < LANES; ++lane) {
      EXPECT_EQ(at->energy[lane], 0.0) << c.name();
      EXPECT_EQ(gradient_of(sample, *at, lane).cwiseAbs().maxCoeff(), 0.0) << c.name();
      EXPECT_EQ(hessian_of(sample, *at, lane).cwiseAbs().maxCoeff(), 0.0) << c.name();
    }
  }
}

TEST(MixedKernels, ProjectionLeavesNoNegativeEigenvalue) {
  int changed = 0;
  for (const Case& c : all_cases()) {
    const Sample sample = random_sample(c, native_isa(), 8, 5u);
    const Evaluation at = evaluate(sample, 0, sample.group.kernel->hessian);
    for (int lane = 0; lane < LANES; ++lane) {
      changed += project_mixed(*sample.group.kernel, *at, lane, {});
      const Eigen::MatrixXd projected = hessian_of(sample, *at, lane);
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(projected, Eigen::EigenvaluesOnly);
      EXPECT_GE(eigen.eigenvalues()[0], -2e-8 * eigen.eigenvalues().maxCoeff()) << c.name();
    }
  }
  EXPECT_GT(changed, 0);
}

TEST(MixedKernels, QuadraticTetsContainLinearOnes) {
  // A deformation that is linear in space has the same energy, whatever functions interpolate it.
  const Mat3 F = rodrigues(Vec3(0.3, 0.5, -0.2)) * Vec3(1.2, 0.9, 1.1).asDiagonal();
  const std::shared_ptr<const geometry::TetMesh> mesh = test::box_mesh(Vec3::Zero(), Vec3(1, 1, 1), 1, 1, 1);
  double energy[2];
  for (int quadratic = 0; quadratic < 2; ++quadratic) {
    FemBody body = test::make_body(mesh, ElasticModel::micropolar, 3.0, 0.3);
    body.element = ElementKind::tet4_one_point;
    if (quadratic == 1)
      body = with_midpoints(body);
    const std::vector<std::int32_t> elements = element_vertices(body);
    const MixedGroup group = *build_mixed_group(body, elements, body.mesh->vertices, 0, native_isa());
    Sample sample;
    sample.group = group;
    for (Eigen::Index i = 0; i < body.mesh->vertices.rows(); ++i) {
      const Vec3 x = F * body.mesh->vertices.row(i).transpose();
      sample.positions.insert(sample.positions.end(), {x[0], x[1], x[2]});
      sample.increments.insert(sample.increments.end(), {0.1, 0.2, 0.3});
      sample.rotations.insert(sample.rotations.end(), {1.0, 0.0, 0.0, 0.0});
    }
    const Evaluation at = evaluate(sample, 0, group.kernel->energy);
    energy[quadratic] = 0.0;
    for (int lane = 0; lane < 6; ++lane)
      energy[quadratic] += at->energy[lane];
  }
  EXPECT_NEAR(energy[1] / energy[0], 1.0, 1e-13);
}

TEST(MixedKernels, PlatesHaveTheEnergyAndGradientOfTheReference) {
  int checked = 0;
  double worst = 0.0;
  for (const json& vector : wry::test::all_vectors()) {
    if (vector.value("kind", "") != "plate")
      continue;
    const json& params = vector.at("params");
    const double mu = params.at("mu"), lambda = params.at("lambda_"), dt = vector.at("dt");
    FemBody body;
    body.element = ElementKind::plate3;
    body.thickness = params.at("h");
    body.material.model = ElasticModel::micropolar;
    body.material.poisson_ratio = lambda / (2.0 * (lambda + mu));
    body.material.youngs_modulus = 2.0 * mu * (1.0 + body.material.poisson_ratio);
    body.material.couple_modulus_ratio = params.at("mu_c").get<double>() / mu;
    body.material.length_scale = params.at("L_c");
    body.material.alpha = params.at("alpha");
    body.material.beta = params.at("beta");
    body.material.gamma = params.at("gamma");
    body.material.plate_bending = params.at("bend") == "h3" ? PlateBending::h3 : PlateBending::curv;
    const auto number = [&](const char* key, int k, int i) {
      return vector.at(key).at(static_cast<std::size_t>(k)).at(static_cast<std::size_t>(i)).get<double>();
    };
    Points vertices = Points::Zero(3, 3);
    Sample sample;
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < 2; ++i)
        vertices(k, i) = number("X", k, i);
      for (int i = 0; i < 3; ++i) {
        sample.positions.push_back(number("x0", k, i) + dt * number("v", k, i));
        sample.increments.push_back(dt * number("omega", k, i));
      }
      for (int i = 0; i < 4; ++i)
        sample.rotations.push_back(number("q0_nodal", k, i));
    }
    for (const Isa isa : runnable_isas()) {
      sample.group = *build_mixed_group(body, {0, 1, 2}, vertices, 0, isa);
      for (int p = 0; p < 3; ++p) {
        for (int i = 0; i < 4; ++i)
          group_entry(sample.group.point_rotations, 0, 12, 4 * p + i) = number("q0_quad", p, i);
      }
      const Evaluation at = evaluate(sample, 0, sample.group.kernel->hessian);
      const double expected = vector.at("out").at("E_int");
      EXPECT_NEAR(at->energy[0], expected, 1e-11 * expected) << vector.at("id");
      const Eigen::VectorXd gradient = dt * gradient_of(sample, *at, 0);
      Eigen::VectorXd reference(18);
      for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 6; ++i)
          reference[i < 3 ? 3 * k + i : 9 + 3 * k + i - 3] =
              vector.at("out").at("grad").at(static_cast<std::size_t>(6 * k + i)).get<double>();
      }
      const double error = (gradient - reference).cwiseAbs().maxCoeff() / reference.cwiseAbs().maxCoeff();
      EXPECT_LE(error, 1e-11) << vector.at("id");
      worst = std::max({worst, error, std::abs(at->energy[0] / expected - 1.0)});
      ++checked;
    }
  }
  std::printf("plate vectors: %d checked, worst relative error %.2g\n", checked, worst);
  EXPECT_GE(checked, 4);
}

} // namespace
} // namespace wry::fem
