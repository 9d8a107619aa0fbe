#include "sim/fem/fem_scene.h"

#include <algorithm>
#include <cmath>

#include <limits>

#include <Eigen/LU>

#include "sim/fem/element_term.h"
#include "sim/fem/kernels/mixed_table.h"
#include "sim/fem/mixed_term.h"
#include "sim/fem/terms/barrier.h"
#include "sim/fem/terms/node_terms.h"

namespace wry::fem {

namespace {

constexpr double POINT_NEAR = 0.5854101966249685; // barycentric weight of the node that a quadrature point lies near
constexpr double POINT_FAR = 0.1381966011250105;

double tet_volume(const geometry::TetMesh& mesh, Eigen::Index tet) {
  const Vec3 origin = mesh.vertices.row(mesh.tets(tet, 0));
  Mat3 edges;
  for (int k = 0; k < 3; ++k)
    edges.col(k) = mesh.vertices.row(mesh.tets(tet, k + 1)).transpose() - origin;
  return edges.determinant() / 6.0;
}

double mean_edge(const geometry::TetMesh& mesh) {
  double sum = 0.0;
  for (Eigen::Index tet = 0; tet < mesh.tets.rows(); ++tet) {
    for (int k = 0; k < 4; ++k) {
      for (int l = k + 1; l < 4; ++l)
        sum += (mesh.vertices.row(mesh.tets(tet, k)) - mesh.vertices.row(mesh.tets(tet, l))).norm();
    }
  }
  return sum / (6.0 * static_cast<double>(mesh.tets.rows()));
}

/// Where the quadrature points rest; corners of an element ascending, as in its group.
std::vector<RestPlace> quadrature_places(const OrderedMesh& ordered, const geometry::TetMesh& original) {
  std::vector<RestPlace> places;
  const geometry::TetMesh& mesh = ordered.mesh;
  for (Eigen::Index tet = 0; tet < mesh.tets.rows(); ++tet) {
    std::array<std::int32_t, 4> corners{};
    for (int k = 0; k < 4; ++k)
      corners[k] = mesh.tets(tet, k);
    std::sort(corners.begin(), corners.end());
    for (const std::int32_t near : corners) {
      RestPlace place;
      place.tet = ordered.tet_of_element[tet];
      for (int k = 0; k < 4; ++k) {
        const std::int32_t vertex = original.tets(place.tet, k);
        place.vertices[k] = vertex;
        place.weights[k] = ordered.node_of_vertex[vertex] == near ? POINT_NEAR : POINT_FAR;
        place.position += place.weights[k] * original.vertices.row(vertex).transpose();
      }
      places.push_back(place);
    }
  }
  return places;
}

/// Factors by tet, in the order of elements.
double factor_of(const std::vector<double>& factors, const OrderedMesh& ordered, Eigen::Index element) {
  return factors.empty() ? 1.0 : factors[ordered.tet_of_element[element]];
}

/// Varies the moduli of a group from element to element, and turns the axes of its curvature.
void vary_material(const FemBody& body, const OrderedMesh& ordered, ElementGroup& group) {
  const MaterialFactors& factors = body.factors;
  const std::size_t lanes = group.volume.size();
  const int moduli = group.curvature == CurvatureModel::isotropic ? 3 : 9;
  const bool turned = !body.tet_rest_rotations.empty() && group.curvature == CurvatureModel::orthotropic;
  if (turned && group.curvature_basis.empty())
    group.curvature_basis.assign(9 * lanes, 0.0);
  if (!factors.couple_modulus_ratio.empty())
    group.couple_equals_shear = false;
  for (int element = 0; element < group.element_count; ++element) {
    const double stiffness = factor_of(factors.youngs_modulus, ordered, element);
    const double length = factor_of(factors.length_scale, ordered, element);
    group.mu[element] *= stiffness;
    group.lambda[element] *= stiffness;
    group.mu_c[element] *= stiffness * factor_of(factors.couple_modulus_ratio, ordered, element);
    const auto entry = [&](AlignedVector<double>& array, int count, int i) -> double& {
      return array[(static_cast<std::size_t>(element / LANES) * count + i) * LANES + element % LANES];
    };
    for (int i = 0; group.curvature != CurvatureModel::none && i < moduli; ++i)
      entry(group.curvature_moduli, moduli, i) *= stiffness * length * length;
    if (!turned)
      continue;
    const Mat3 basis = body.tet_rest_rotations[ordered.tet_of_element[element]] * body.material.curvature_basis;
    for (int i = 0; i < 9; ++i)
      entry(group.curvature_basis, 9, i) = basis(i / 3, i % 3);
  }
  // Padding lanes need axes too.
  for (std::size_t lane = group.element_count; turned && lane < lanes; ++lane) {
    for (std::size_t i = 0; i < 9; i += 4)
      group.curvature_basis[(lane / LANES * 9 + i) * LANES + lane % LANES] = 1.0;
  }
}

void add_masses(const OrderedMesh& ordered, const FemBody& body, int first_node, FemModel& model) {
  const geometry::TetMesh& mesh = ordered.mesh;
  const FemMaterial& material = body.material;
  const bool rotary = is_micropolar(material.model) && material.rotary_inertia > 0.0;
  model.any_rotary = model.any_rotary || rotary;
  for (Eigen::Index tet = 0; tet < mesh.tets.rows(); ++tet) {
    const double share = 0.25 * tet_volume(mesh, tet) * factor_of(body.factors.density, ordered, tet);
    for (int k = 0; k < 4; ++k) {
      model.mass[first_node + mesh.tets(tet, k)] += material.density * share;
      if (rotary)
        model.rotary_mass[first_node + mesh.tets(tet, k)] += material.rotary_inertia * share;
    }
  }
}

/// Nodes, layout and empty masses of a body whose ordered mesh was added last.
int add_nodes(const FemBody& body, FemScene& scene) {
  FemModel& model = scene.model;
  const geometry::TetMesh& mesh = scene.meshes.back().mesh;
  const int first_node = model.layout.node_count();
  const int count = static_cast<int>(mesh.vertices.rows());
  const bool micropolar = is_micropolar(body.material.model);
  model.bodies.push_back({body.name, first_node, count, micropolar, is_plate(body.element), {}});
  model.any_micropolar = model.any_micropolar || micropolar;
  model.layout.append(count, micropolar ? 6 : 3);
  model.body_of_node.resize(first_node + count, static_cast<int>(model.bodies.size()) - 1);
  model.mass.resize(first_node + count, 0.0);
  model.rotary_mass.resize(first_node + count, 0.0);
  if (body.material.mass_damping > 0.0 || !model.damping.empty()) {
    model.damping.resize(first_node, 0.0);
    model.damping.resize(first_node + count, body.material.mass_damping);
  }
  if (body.thickness > 0.0 || !model.half_thickness.empty()) {
    model.half_thickness.resize(first_node, 0.0);
    model.half_thickness.resize(first_node + count, 0.5 * body.thickness);
  }
  scene.start_positions.conservativeResize(first_node + count, 3);
  scene.start_positions.bottomRows(count) = mesh.vertices;
  return first_node;
}

void suggest_contact_distance(double edge, FemScene& scene) {
  scene.edges.push_back(edge);
  const Points& vertices = scene.meshes.back().mesh.vertices;
  const Vec3 extent = vertices.colwise().maxCoeff() - vertices.colwise().minCoeff();
  scene.suggested_contact_distance =
      std::min(scene.suggested_contact_distance, std::min(2e-3 * extent.norm(), 0.2 * edge));
}

Status add_tets(const FemBody& body, Isa isa, const Threads& threads, FemScene& scene) {
  const OrderedMesh& ordered = scene.meshes.emplace_back(order_for_locality(*body.mesh));
  const geometry::TetMesh& mesh = ordered.mesh;
  const int first_node = add_nodes(body, scene);
  Result<ElementGroup> group = build_element_group(mesh, body.material, first_node);
  if (!group)
    return std::move(group).error();
  add_masses(ordered, body, first_node, scene.model);
  suggest_contact_distance(mean_edge(mesh), scene);
  vary_material(body, ordered, *group);
  std::vector<RestPlace> places;
  if (body.rest_curvature)
    places = quadrature_places(ordered, *body.mesh);
  auto elements =
      std::make_unique<ElementTerm>(std::move(group).value(), std::move(places), body.rest_curvature, isa, threads);
  if (!body.rest_curvature_moves)
    elements->freeze_rest_curvature();
  if (!elements->has_kernel())
    return make_error(ErrorCode::unavailable,
                      "body '{}', material '{}': this model has no element kernel in this build", body.name,
                      body.material.name);
  scene.elements.push_back(std::move(elements));
  return {};
}

/// Masses of the elements of a mixed body; the mean length of edges between neighbouring nodes.
double add_mixed_masses(const FemBody& body, const MixedGroup& group, const Points& vertices, int first_node,
                        FemModel& model) {
  const int corners = group.kernel->corners;
  double edges = 0.0;
  for (int element = 0; element < group.element_count; ++element) {
    const double volume = group.volume[static_cast<std::size_t>(element)];
    for (int k = 0; k < group.kernel->nodes; ++k)
      model.mass[group.node(element, k)] += body.material.density * volume * mass_share(body.element, k);
    for (int k = 0; k < corners; ++k) {
      model.rotary_mass[group.node(element, k)] += body.material.rotary_inertia * volume / corners;
      const auto place = [&](int corner) { return vertices.row(group.node(element, corner) - first_node); };
      edges += (place(k) - place((k + 1) % corners)).norm();
    }
  }
  model.any_rotary = model.any_rotary || body.material.rotary_inertia > 0.0;
  return edges / (corners * group.element_count) / (is_quadratic(body.element) ? 2.0 : 1.0);
}

/// Where the quadrature points rest, in the order of the elements.
std::vector<RestPlace> mixed_places(const MixedKernel& kernel, const std::vector<std::int32_t>& elements,
                                    const OrderedMesh& ordered) {
  std::vector<std::int32_t> vertex_of_node(ordered.node_of_vertex.size());
  for (std::size_t vertex = 0; vertex < vertex_of_node.size(); ++vertex)
    vertex_of_node[static_cast<std::size_t>(ordered.node_of_vertex[vertex])] = static_cast<std::int32_t>(vertex);
  const Points points = mixed_points(kernel, elements, ordered.mesh.vertices);
  std::vector<RestPlace> places(static_cast<std::size_t>(points.rows()));
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    RestPlace& place = places[static_cast<std::size_t>(i)];
    const Eigen::Index element = i / kernel.points;
    place.position = points.row(i);
    for (int k = 0; k < kernel.corners; ++k) {
      place.vertices[k] = vertex_of_node[static_cast<std::size_t>(elements[element * kernel.nodes + k])];
      place.weights[k] = point_weight(kernel, static_cast<int>(i % kernel.points), k);
    }
  }
  return places;
}

Status add_mixed(const FemBody& body, Isa isa, const Threads& threads, FemScene& scene) {
  std::vector<std::int32_t> elements = element_vertices(body);
  const MixedKernel* kernel = find_mixed_kernel(body.element, isa);
  OrderedMesh& ordered = scene.meshes.emplace_back(order_for_locality(body.mesh->vertices, kernel->nodes, elements));
  const int first_node = add_nodes(body, scene);
  Result<MixedGroup> group = build_mixed_group(body, elements, ordered.mesh.vertices, first_node, isa);
  if (!group)
    return std::move(group).error();
  suggest_contact_distance(add_mixed_masses(body, *group, ordered.mesh.vertices, first_node, scene.model), scene);
  const int first_middle = static_cast<int>(body.mesh->vertices.rows()) - static_cast<int>(body.edges.size());
  for (std::size_t i = 0; i < body.edges.size(); ++i) {
    const auto node = [&](std::int32_t vertex) { return first_node + ordered.node_of_vertex[vertex]; };
    scene.model.bodies.back().midpoints.push_back(
        {node(first_middle + static_cast<int>(i)), {node(body.edges[i][0]), node(body.edges[i][1])}});
  }
  std::vector<RestPlace> places;
  if (body.rest_curvature)
    places = mixed_places(*kernel, elements, ordered);
  scene.elements.push_back(
      std::make_unique<MixedTerm>(std::move(group).value(), std::move(places), body.rest_curvature, threads));
  if (!body.rest_curvature_moves)
    scene.elements.back()->freeze_rest_curvature();
  return {};
}

Status add_body(const FemBody& body, Isa isa, const Threads& threads, FemScene& scene) {
  return body.element == ElementKind::tet4 ? add_tets(body, isa, threads, scene) : add_mixed(body, isa, threads, scene);
}

} // namespace

std::vector<int> nodes_of(const FemScene& scene, int body, const std::vector<std::int32_t>& vertices) {
  std::vector<int> nodes;
  nodes.reserve(vertices.size());
  for (const std::int32_t vertex : vertices)
    nodes.push_back(scene.model.bodies[body].first_node + scene.meshes[body].node_of_vertex[vertex]);
  return nodes;
}

Result<FemScene> build_scene(const FemPlan& plan, Isa isa, const Threads& threads) {
  if (Status status = check_plan(plan); !status)
    return status.error();
  FemScene scene;
  scene.model.planes = plan.planes;
  scene.model.gravity = plan.gravity;
  scene.model.friction_velocity = plan.settings.friction_velocity;
  scene.suggested_contact_distance = std::numeric_limits<double>::infinity();
  for (const FemBody& body : plan.bodies) {
    if (Status status = add_body(body, isa, threads, scene); !status)
      return status.error();
  }
  for (const FemLoad& load : plan.loads)
    scene.model.loads.push_back({nodes_of(scene, load.body, load.nodes), load.shares, load.force, load.torque});
  return scene;
}

namespace {

/// The least gap at which a body, moved as a whole, is carried by the barrier: its weight against the plane, or d-hat.
double resting_gap(const FemScene& scene, const BodyNodes& body, const scene::PlaneCollider& plane, double least,
                   const ContactState& contact, double stiffness) {
  double weight = 0.0;
  for (int node = body.first_node; node < body.first_node + body.node_count; ++node)
    weight -= scene.model.mass[node] * scene.model.gravity.dot(plane.normal);
  double low = 0.1 * contact.distance;
  double high = contact.distance;
  for (int round = 0; round < 60; ++round) {
    const double gap = 0.5 * (low + high);
    double force = 0.0;
    for (int node = body.first_node; node < body.first_node + body.node_count; ++node) {
      if (!contact.ignored[node]) {
        const double above = plane_gap(scene.model, plane, scene.start_positions, node) - least;
        force -= evaluate_barrier(above + gap, contact.distance, stiffness).slope;
      }
    }
    (force > weight ? low : high) = gap;
  }
  return high;
}

} // namespace

Status clear_planes(const FemPlan& plan, const ContactState& contact, FemScene& scene) {
  for (std::size_t index = 0; index < scene.model.bodies.size(); ++index) {
    const BodyNodes& body = scene.model.bodies[index];
    for (const scene::PlaneCollider& plane : plan.planes) {
      double least = std::numeric_limits<double>::infinity();
      int lowest = 0;
      for (int node = body.first_node; node < body.first_node + body.node_count; ++node) {
        const double gap = plane_gap(scene.model, plane, scene.start_positions, node);
        if (!contact.ignored[node] && gap < least) {
          least = gap;
          lowest = node;
        }
      }
      if (least < -1e-3 * contact.distance)
        return make_error(ErrorCode::bad_input,
                          "body '{}' starts {:.3g} m below plane '{}' (vertex {}); move the body or the plane",
                          body.name, -least, plane.name, scene.meshes[index].vertex_of_node[lowest - body.first_node]);
      if (least < 0.1 * contact.distance) {
        const double gap = resting_gap(scene, body, plane, least, contact, contact.stiffness[index]);
        const Vec3 lift = (gap - least) * plane.normal;
        scene.start_positions.middleRows(body.first_node, body.node_count).rowwise() += lift.transpose();
      }
    }
  }
  return {};
}

std::vector<double> choose_contact_stiffness(const FemPlan& plan, const FemScene& scene, double distance) {
  std::vector<double> stiffness;
  for (std::size_t index = 0; index < plan.bodies.size(); ++index) {
    const BodyNodes& body = scene.model.bodies[index];
    double mass = 0.0;
    for (int node = body.first_node; node < body.first_node + body.node_count; ++node)
      mass += scene.model.mass[node];
    // As stiff as an element, and stiff enough that a foot of a twentieth of the nodes' surface share carries the body
    // at about half of d-hat.
    const double feet = std::max(3.0, std::pow(static_cast<double>(body.node_count), 2.0 / 3.0) / 4.0);
    const double by_elasticity = plan.bodies[index].material.youngs_modulus * scene.edges[index];
    const double by_weight = mass * plan.gravity.norm() / (feet * distance);
    stiffness.push_back(plan.settings.contact_stiffness.value_or(std::max(by_elasticity, by_weight)));
  }
  return stiffness;
}

} // namespace wry::fem
