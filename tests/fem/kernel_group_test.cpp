#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/fem/kernel_support.h"

namespace wry::fem {
namespace {

geometry::TetMesh two_tets() {
  geometry::TetMesh mesh;
  mesh.vertices.resize(5, 3);
  mesh.vertices << 1, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 3, 1, 1, 1;
  mesh.tets.resize(2, 4);
  mesh.tets << 1, 0, 2, 3, 4, 3, 2, 0;
  return mesh;
}

TEST(ElementGroup, HoldsVolumesAndShapeGradientsWithAscendingNodes) {
  FemMaterial material;
  material.youngs_modulus = 2.6;
  material.poisson_ratio = 0.3;
  const ElementGroup group = *build_element_group(two_tets(), material, 100);
  EXPECT_EQ(group.element_count, 2);
  EXPECT_EQ(group.batch_count, 1);
  const auto node = [&](int k, int element) { return group.nodes[static_cast<std::size_t>(k * LANES + element)]; };
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(node(k, 0), 100 + k);
    EXPECT_EQ(node(k, 1), (std::array{100, 102, 103, 104}[static_cast<std::size_t>(k)]));
  }
  EXPECT_DOUBLE_EQ(group.volume[0], 1.0);
  EXPECT_DOUBLE_EQ(group.mu[0], 1.0);
  EXPECT_DOUBLE_EQ(group.lambda[0], 1.5);
  // phi of mesh vertex 1, the origin, is 1 - x - y/2 - z/3
  const auto gradient = [&](int i) { return group.shape_gradients[static_cast<std::size_t>(i * LANES)]; };
  EXPECT_DOUBLE_EQ(gradient(0), -1.0);
  EXPECT_DOUBLE_EQ(gradient(1), -0.5);
  EXPECT_DOUBLE_EQ(gradient(2), -1.0 / 3.0);
  EXPECT_EQ(group.volume[2], 0.0);
}

TEST(ElementGroup, RestStateHasNeitherEnergyNorForces) {
  const geometry::TetMesh mesh = two_tets();
  for (const KernelCase& kernel_case : all_kernel_cases()) {
    FemMaterial material;
    material.model = kernel_case.model;
    material.youngs_modulus = 1.0;
    material.couple_modulus_ratio = kernel_case.couple_equals_shear ? 1.0 : 0.5;
    material.length_scale = 1.0;
    material.curvature = kernel_case.curvature;
    material.curvature_stiffness.setConstant(2.0);
    if (kernel_case.has_basis)
      material.curvature_basis << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    const ElementGroup group = *build_element_group(mesh, material, 0);
    EXPECT_EQ(group.curvature, kernel_case.curvature);
    EXPECT_EQ(group.curvature_basis.empty(), !kernel_case.has_basis);
    const std::vector<double> increments(15, 0.0);
    std::vector<double> rotations(20, 0.0);
    for (std::size_t i = 0; i < 20; i += 4)
      rotations[i] = 1.0;
    const NodeFields fields{mesh.vertices.data(), increments.data(), rotations.data()};
    const auto out = std::make_unique<BatchDerivatives>();
    select_kernel(group, native_isa()).gradient(group, fields, 0, *out);
    for (int lane = 0; lane < LANES; ++lane) {
      EXPECT_NEAR(out->energy[lane], 0.0, 1e-30) << kernel_case.name();
      for (int i = 0; i < 4 * group.dofs_per_node(); ++i)
        EXPECT_NEAR(out->gradient[i * LANES + lane], 0.0, 1e-15) << kernel_case.name();
    }
  }
}

TEST(ElementGroup, CurvatureIsLeftOutWithoutALengthScale) {
  FemMaterial material;
  material.model = ElasticModel::micropolar;
  material.curvature = CurvatureModel::isotropic;
  material.length_scale = 0.0;
  EXPECT_EQ(build_element_group(two_tets(), material, 0)->curvature, CurvatureModel::none);
}

TEST(ElementGroup, RefusesInvertedFlatAndInfiniteTets) {
  geometry::TetMesh mesh = two_tets();
  std::swap(mesh.tets(1, 0), mesh.tets(1, 1));
  const auto inverted = build_element_group(mesh, {}, 0);
  ASSERT_FALSE(inverted.ok());
  EXPECT_EQ(inverted.error().code, ErrorCode::bad_input);
  EXPECT_THAT(inverted.error().message, testing::HasSubstr("tet 1"));
  mesh = two_tets();
  mesh.vertices.row(3) = mesh.vertices.row(2);
  EXPECT_FALSE(build_element_group(mesh, {}, 0).ok());
  mesh = two_tets();
  mesh.vertices(4, 0) = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(build_element_group(mesh, {}, 0).ok());
}

TEST(ElementGroup, AnEmptyMeshHasNoBatches) {
  geometry::TetMesh mesh;
  mesh.vertices.resize(0, 3);
  mesh.tets.resize(0, 4);
  const auto group = build_element_group(mesh, {}, 0);
  ASSERT_TRUE(group.ok());
  EXPECT_EQ(group->batch_count, 0);
}

} // namespace
} // namespace wry::fem
