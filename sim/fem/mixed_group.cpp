#include "sim/fem/mixed_group.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "sim/base/rotation.h"
#include "sim/fem/kernels/mixed_table.h"

namespace wry::fem {

namespace {

/// Beyond a limit by 1 % of strain, a membrane is as stiff as by Young's modulus at a strain of one.
constexpr double LIMIT_STIFFNESS = 1e4;

template <class T> T& entry(AlignedVector<T>& array, std::size_t element, std::size_t count, std::size_t i) {
  return array[(element / LANES * count + i) * LANES + element % LANES];
}

const double* from(const AlignedVector<double>& array, int count, int batch) {
  return array.empty() ? nullptr : array.data() + static_cast<std::size_t>(batch) * count * LANES;
}

double shear_modulus(const FemMaterial& material) {
  return material.youngs_modulus / (2.0 * (1.0 + material.poisson_ratio));
}

void fill(AlignedVector<double>& array, std::size_t lanes, const std::vector<double>& values) {
  array.resize(lanes * values.size());
  for (std::size_t element = 0; element < lanes; ++element) {
    for (std::size_t i = 0; i < values.size(); ++i)
      entry(array, element, values.size(), i) = values[i];
  }
}

/// Moduli of curvature, empty where there is none.
std::vector<double> curvature_moduli(const FemBody& body, MixedGroup& group) {
  const FemMaterial& material = body.material;
  const double mu = shear_modulus(material);
  const double scale = mu * material.length_scale * material.length_scale;
  if (is_plate(body.element)) {
    group.curvature = MixedCurvature::plate;
    // The energy per volume: that of the spec, which is per area, over the thickness.
    if (material.plate_bending == PlateBending::h3) {
      const double twelfth = body.thickness * body.thickness / 6.0;
      const double nu = material.poisson_ratio;
      return {twelfth * mu, twelfth * mu * material.couple_modulus_ratio, twelfth * mu * nu / (1.0 - nu)};
    }
    if (scale > 0.0)
      return {scale * material.alpha, scale * material.beta, scale * material.gamma};
  } else if (scale > 0.0 && material.curvature == CurvatureModel::isotropic) {
    group.curvature = MixedCurvature::isotropic;
    return {scale * material.alpha, scale * material.beta, scale * material.gamma};
  } else if (scale > 0.0 && material.curvature == CurvatureModel::orthotropic) {
    group.curvature = MixedCurvature::orthotropic;
    std::vector<double> moduli;
    for (Eigen::Index i = 0; i < 9; ++i)
      moduli.push_back(scale * material.curvature_stiffness(i / 3, i % 3));
    return moduli;
  }
  group.curvature = MixedCurvature::none;
  return {};
}

void set_material(const FemBody& body, MixedGroup& group) {
  const FemMaterial& material = body.material;
  const std::size_t lanes = group.volume.size();
  const double mu = shear_modulus(material), nu = material.poisson_ratio;
  // Of plates in plane stress: lambda' tr^2 with lambda' = mu lambda / (2 mu + lambda), written as lambda/2 tr^2.
  const double lambda = is_plate(body.element) ? 2.0 * mu * nu / (1.0 - nu) : 2.0 * mu * nu / (1.0 - 2.0 * nu);
  fill(group.mu, lanes, {mu});
  fill(group.lambda, lanes, {lambda});
  fill(group.mu_c, lanes, {material.couple_modulus_ratio * mu});
  group.couple_equals_shear = material.couple_modulus_ratio == 1.0;
  fill(group.moduli, lanes, curvature_moduli(body, group));
  if (group.curvature == MixedCurvature::orthotropic && material.curvature_basis != Mat3::Identity()) {
    const Vec4 q = quaternion_of(material.curvature_basis);
    fill(group.frame, lanes, {q[0], q[1], q[2], q[3]});
  }
  if (material.max_stretch)
    fill(group.stretch_limit, lanes,
         {*material.max_stretch * *material.max_stretch, LIMIT_STIFFNESS * material.youngs_modulus});
}

/// Gradients and volume of one element.
Status set_shape(const FemBody& body, const Points& vertices, const std::int32_t* nodes, std::size_t element,
                 MixedGroup& group) {
  const auto edge = [&](int k) { return Vec3((vertices.row(nodes[k]) - vertices.row(nodes[0])).transpose()); };
  const auto set_gradient = [&](std::size_t k, const Vec3& gradient) {
    for (std::size_t i = 0; i < 3; ++i)
      entry(group.gradients, element, static_cast<std::size_t>(3 * (group.kernel->corners - 1)), 3 * k + i) =
          gradient[static_cast<Eigen::Index>(i)];
  };
  if (!is_plate(body.element)) {
    Mat3 edges;
    for (int k = 0; k < 3; ++k)
      edges.col(k) = edge(k + 1);
    const double volume = edges.determinant() / 6.0;
    if (!(volume > 0.0))
      return make_error(ErrorCode::bad_input, "body '{}': tet {} has the volume {} m^3, but it must be positive",
                        body.name, element, volume);
    group.volume[element] = volume;
    const Mat3 gradients = edges.inverse();
    for (std::size_t k = 0; k < 3; ++k)
      set_gradient(k, gradients.row(static_cast<Eigen::Index>(k)));
    return {};
  }
  const Vec3 a = edge(1), b = edge(2);
  const Vec3 normal = a.cross(b);
  const double twice_area = normal.norm();
  if (!(twice_area > 1e-12 * std::max(a.squaredNorm(), b.squaredNorm())) || !std::isfinite(twice_area))
    return make_error(ErrorCode::bad_input, "body '{}': triangle {} (vertices {} {} {}) has no area", body.name,
                      element, nodes[0], nodes[1], nodes[2]);
  group.volume[element] = 0.5 * twice_area * body.thickness;
  const Vec3 n = normal / twice_area;
  set_gradient(0, b.cross(n) / twice_area);
  set_gradient(1, n.cross(a) / twice_area);
  Mat3 axes;
  axes << a.normalized(), n.cross(a.normalized()), n;
  const Vec4 q = quaternion_of(axes);
  for (std::size_t i = 0; i < 4; ++i)
    entry(group.frame, element, 4, i) = q[static_cast<Eigen::Index>(i)];
  return {};
}

} // namespace

MixedBatch MixedGroup::batch(int index) const {
  MixedBatch view;
  view.curvature = curvature;
  view.couple_equals_shear = couple_equals_shear;
  view.nodes = nodes.data() + static_cast<std::size_t>(index) * kernel->nodes * LANES;
  view.gradients = from(gradients, 3 * (kernel->corners - 1), index);
  view.volume = from(volume, 1, index);
  view.mu = from(mu, 1, index);
  view.lambda = from(lambda, 1, index);
  view.mu_c = from(mu_c, 1, index);
  view.moduli = from(moduli, curvature == MixedCurvature::orthotropic ? 9 : 3, index);
  view.frame = from(frame, 4, index);
  view.rest_curvature = from(rest_curvature, 9 * kernel->points, index);
  view.point_rotations = from(point_rotations, 4 * kernel->points, index);
  view.stretch_limit = from(stretch_limit, 2, index);
  return view;
}

std::vector<std::int32_t> element_vertices(const FemBody& body) {
  std::map<std::array<std::int32_t, 2>, std::int32_t> middle;
  const auto first_middle =
      static_cast<std::int32_t>(body.mesh->vertices.rows()) - static_cast<std::int32_t>(body.edges.size());
  for (std::size_t i = 0; i < body.edges.size(); ++i)
    middle[body.edges[i]] = first_middle + static_cast<std::int32_t>(i);
  std::vector<std::int32_t> vertices;
  const auto add = [&](const auto& elements) {
    for (Eigen::Index element = 0; element < elements.rows(); ++element) {
      for (Eigen::Index k = 0; k < elements.cols(); ++k)
        vertices.push_back(elements(element, k));
      for (Eigen::Index k = 0; is_quadratic(body.element) && k < elements.cols(); ++k) {
        for (Eigen::Index l = k + 1; l < elements.cols(); ++l) {
          const auto [low, high] = std::minmax(elements(element, k), elements(element, l));
          vertices.push_back(middle.at({low, high}));
        }
      }
    }
  };
  if (is_plate(body.element))
    add(body.triangles);
  else
    add(body.mesh->tets);
  return vertices;
}

Result<MixedGroup> build_mixed_group(const FemBody& body, const std::vector<std::int32_t>& elements,
                                     const Points& vertices, int node_offset, Isa isa) {
  MixedGroup group;
  group.kernel = find_mixed_kernel(body.element, isa);
  if (group.kernel == nullptr || body.material.model != ElasticModel::micropolar)
    return make_error(ErrorCode::unavailable,
                      "body '{}', material '{}': only the models micropolar and plate have elements of this kind",
                      body.name, body.material.name);
  const std::size_t per_element = static_cast<std::size_t>(group.kernel->nodes);
  const std::size_t count = elements.size() / per_element;
  group.element_count = static_cast<int>(count);
  group.batch_count = (group.element_count + LANES - 1) / LANES;
  const std::size_t lanes = static_cast<std::size_t>(group.batch_count) * LANES;
  group.nodes.assign(per_element * lanes, 0);
  group.gradients.assign(3 * static_cast<std::size_t>(group.kernel->corners - 1) * lanes, 0.0);
  group.volume.assign(lanes, 0.0);
  if (is_plate(body.element))
    fill(group.frame, lanes, {1.0, 0.0, 0.0, 0.0});
  for (std::size_t element = 0; element < count; ++element) {
    const std::int32_t* nodes = elements.data() + element * per_element;
    for (std::size_t k = 0; k < per_element; ++k)
      entry(group.nodes, element, per_element, k) = nodes[k] + node_offset;
    if (Status status = set_shape(body, vertices, nodes, element, group); !status)
      return status.error();
  }
  for (std::size_t lane = count; lane < lanes; ++lane) {
    for (std::size_t k = 0; k < per_element; ++k)
      entry(group.nodes, lane, per_element, k) = entry(group.nodes, count - 1, per_element, k);
  }
  set_material(body, group);
  const std::size_t points = static_cast<std::size_t>(group.kernel->points);
  group.point_rotations.assign(4 * points * lanes, 0.0);
  for (std::size_t element = 0; element < lanes; ++element) {
    for (std::size_t p = 0; p < points; ++p)
      entry(group.point_rotations, element, 4 * points, 4 * p) = 1.0;
  }
  return group;
}

double point_weight(const MixedKernel& kernel, int point, int corner) {
  const double near = kernel.points == 1 ? 0.25 : kernel.plate ? 2.0 / 3.0 : 0.5854101966249685;
  return corner == point ? near : (1.0 - near) / (kernel.corners - 1);
}

Points mixed_points(const MixedKernel& kernel, const std::vector<std::int32_t>& elements, const Points& vertices) {
  const Eigen::Index count = static_cast<Eigen::Index>(elements.size()) / kernel.nodes;
  Points points(count * kernel.points, 3);
  for (Eigen::Index element = 0; element < count; ++element) {
    for (int p = 0; p < kernel.points; ++p) {
      Vec3 place = Vec3::Zero();
      for (int k = 0; k < kernel.corners; ++k)
        place += point_weight(kernel, p, k) * vertices.row(elements[element * kernel.nodes + k]).transpose();
      points.row(element * kernel.points + p) = place;
    }
  }
  return points;
}

double mass_share(ElementKind kind, int node) {
  switch (kind) {
  case ElementKind::tet10:
    return node < 4 ? 1.0 / 36.0 : 4.0 / 27.0;
  case ElementKind::plate6:
    return node < 3 ? 1.0 / 19.0 : 16.0 / 57.0;
  case ElementKind::plate3:
    return 1.0 / 3.0;
  case ElementKind::tet4:
  case ElementKind::tet4_one_point:
    return 0.25;
  }
  return 0.0;
}

} // namespace wry::fem
