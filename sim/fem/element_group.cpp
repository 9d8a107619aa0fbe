#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <Eigen/Dense>

#include "sim/fem/element_kernels.h"

namespace wry::fem {

namespace {

/// Allocates the arrays that every group has, padding lanes as elements without volume or shape.
ElementGroup allocate_group(const FemMaterial& material, std::size_t element_count) {
  ElementGroup group;
  group.model = material.model;
  group.couple_equals_shear = material.couple_modulus_ratio == 1.0;
  group.element_count = static_cast<int>(element_count);
  group.batch_count = (group.element_count + LANES - 1) / LANES;
  const std::size_t lanes = static_cast<std::size_t>(group.batch_count) * LANES;
  group.nodes.assign(4 * lanes, 0);
  group.shape_gradients.assign(9 * lanes, 0.0);
  group.volume.assign(lanes, 0.0);
  const double mu = material.youngs_modulus / (2.0 * (1.0 + material.poisson_ratio));
  const double nu = material.poisson_ratio;
  group.mu.assign(lanes, mu);
  group.lambda.assign(lanes, material.youngs_modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)));
  group.mu_c.assign(lanes, material.couple_modulus_ratio * mu);
  return group;
}

/// Writes entry i of an array with `count` entries per element for one element.
template <class T> T& entry(AlignedVector<T>& array, std::size_t element, std::size_t count, std::size_t i) {
  return array[(element / LANES * count + i) * LANES + element % LANES];
}

void add_curvature(const FemMaterial& material, ElementGroup& group) {
  const double scale = group.mu.empty() ? 0.0 : group.mu[0] * material.length_scale * material.length_scale;
  if (material.curvature == CurvatureModel::none || scale == 0.0)
    return;
  group.curvature = material.curvature;
  const std::size_t lanes = group.volume.size();
  const auto fill = [&](AlignedVector<double>& array, std::size_t count, auto&& value) {
    array.resize(count * lanes);
    for (std::size_t element = 0; element < lanes; ++element) {
      for (std::size_t i = 0; i < count; ++i)
        entry(array, element, count, i) = value(static_cast<Eigen::Index>(i));
    }
  };
  if (material.curvature == CurvatureModel::isotropic) {
    const std::array moduli = {material.alpha, material.beta, material.gamma};
    fill(group.curvature_moduli, 3, [&](Eigen::Index i) { return scale * moduli[static_cast<std::size_t>(i)]; });
    return;
  }
  fill(group.curvature_moduli, 9, [&](Eigen::Index i) { return scale * material.curvature_stiffness(i / 3, i % 3); });
  if (material.curvature_basis != Mat3::Identity())
    fill(group.curvature_basis, 9, [&](Eigen::Index i) { return material.curvature_basis(i / 3, i % 3); });
}

} // namespace

Result<ElementGroup> build_element_group(const geometry::TetMesh& mesh, const FemMaterial& material, int node_offset) {
  ElementGroup group = allocate_group(material, static_cast<std::size_t>(mesh.tets.rows()));
  for (Eigen::Index tet = 0; tet < mesh.tets.rows(); ++tet) {
    std::array<std::int32_t, 4> corners{};
    for (int k = 0; k < 4; ++k)
      corners[static_cast<std::size_t>(k)] = mesh.tets(tet, k);
    const auto edge = [&](int k) {
      return Vec3(
          (mesh.vertices.row(corners[static_cast<std::size_t>(k)]) - mesh.vertices.row(corners[0])).transpose());
    };
    const double signed_volume = edge(1).cross(edge(2)).dot(edge(3)) / 6.0;
    if (!(signed_volume > 0.0) || !std::isfinite(signed_volume))
      return make_error(ErrorCode::bad_input,
                        "material '{}': tet {} (vertices {} {} {} {}) has the volume {} m^3, but it must be positive; "
                        "repair the mesh or mesh it anew at another resolution",
                        material.name, tet, corners[0], corners[1], corners[2], corners[3], signed_volume);
    std::sort(corners.begin(), corners.end());
    Mat3 edges;
    for (int k = 0; k < 3; ++k)
      edges.col(k) = edge(k + 1);
    const Mat3 gradients = edges.inverse(); // row k - 1: the gradient of shape function k
    const auto element = static_cast<std::size_t>(tet);
    for (std::size_t k = 0; k < 4; ++k)
      entry(group.nodes, element, 4, k) = corners[k] + node_offset;
    for (int i = 0; i < 9; ++i)
      entry(group.shape_gradients, element, 9, static_cast<std::size_t>(i)) = gradients(i / 3, i % 3);
    group.volume[element] = signed_volume;
  }
  // Padding lanes read the nodes of the last element, which exist, but have no volume and no shape.
  for (std::size_t lane = static_cast<std::size_t>(group.element_count); lane < group.volume.size(); ++lane) {
    for (std::size_t k = 0; k < 4; ++k)
      entry(group.nodes, lane, 4, k) = entry(group.nodes, static_cast<std::size_t>(group.element_count) - 1, 4, k);
  }
  if (!is_micropolar(material.model))
    return group;
  add_curvature(material, group);
  group.point_rotations.assign(group.volume.size() * 16, 0.0);
  for (std::size_t element = 0; element < group.volume.size(); ++element) {
    for (std::size_t point = 0; point < POINTS; ++point)
      entry(group.point_rotations, element, 16, 4 * point) = 1.0;
  }
  return group;
}

} // namespace wry::fem
