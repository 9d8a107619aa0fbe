#include "sim/fem/fem_scene.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>
#include <limits>

#include "sim/fem/terms/barrier.h"

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

/// Rest positions of the quadrature points; corners of an element ascending, as in its group.
Points quadrature_points(const geometry::TetMesh& mesh) {
  Points points(4 * mesh.tets.rows(), 3);
  for (Eigen::Index tet = 0; tet < mesh.tets.rows(); ++tet) {
    std::array<std::int32_t, 4> corners{};
    for (int k = 0; k < 4; ++k)
      corners[k] = mesh.tets(tet, k);
    std::sort(corners.begin(), corners.end());
    for (int point = 0; point < 4; ++point) {
      Vec3 place = Vec3::Zero();
      for (int k = 0; k < 4; ++k)
        place += (k == point ? POINT_NEAR : POINT_FAR) * mesh.vertices.row(corners[k]).transpose();
      points.row(4 * tet + point) = place;
    }
  }
  return points;
}

void add_masses(const geometry::TetMesh& mesh, const FemMaterial& material, int first_node, FemModel& model) {
  const bool rotary = is_micropolar(material.model) && material.rotary_inertia > 0.0;
  model.any_rotary = model.any_rotary || rotary;
  for (Eigen::Index tet = 0; tet < mesh.tets.rows(); ++tet) {
    const double share = 0.25 * tet_volume(mesh, tet);
    for (int k = 0; k < 4; ++k) {
      model.mass[first_node + mesh.tets(tet, k)] += material.density * share;
      if (rotary)
        model.rotary_mass[first_node + mesh.tets(tet, k)] += material.rotary_inertia * share;
    }
  }
}

Status add_body(const FemBody& body, Isa isa, const Threads& threads, FemScene& scene) {
  FemModel& model = scene.model;
  const OrderedMesh& ordered = scene.meshes.emplace_back(order_for_locality(*body.mesh));
  const geometry::TetMesh& mesh = ordered.mesh;
  const int first_node = model.layout.node_count();
  const int count = static_cast<int>(mesh.vertices.rows());
  Result<ElementGroup> group = build_element_group(mesh, body.material, first_node);
  if (!group)
    return std::move(group).error();
  const bool micropolar = is_micropolar(body.material.model);
  model.bodies.push_back({body.name, first_node, count, micropolar});
  model.any_micropolar = model.any_micropolar || micropolar;
  model.layout.append(count, micropolar ? 6 : 3);
  model.body_of_node.resize(first_node + count, static_cast<int>(model.bodies.size()) - 1);
  model.mass.resize(first_node + count, 0.0);
  model.rotary_mass.resize(first_node + count, 0.0);
  add_masses(mesh, body.material, first_node, model);
  scene.start_positions.conservativeResize(first_node + count, 3);
  scene.start_positions.bottomRows(count) = mesh.vertices;
  scene.edges.push_back(mean_edge(mesh));
  const Vec3 extent = mesh.vertices.colwise().maxCoeff() - mesh.vertices.colwise().minCoeff();
  scene.suggested_contact_distance =
      std::min(scene.suggested_contact_distance, std::min(2e-3 * extent.norm(), 0.2 * scene.edges.back()));
  Points points = body.rest_curvature ? quadrature_points(mesh) : Points();
  scene.elements.push_back(
      std::make_unique<ElementTerm>(std::move(group).value(), std::move(points), body.rest_curvature, isa, threads));
  if (!scene.elements.back()->has_kernel())
    return make_error(ErrorCode::unavailable,
                      "body '{}', material '{}': this model has no element kernel in this build", body.name,
                      body.material.name);
  return {};
}

} // namespace

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
  return scene;
}

namespace {

double gap_to(const scene::PlaneCollider& plane, const Points& positions, int node) {
  return plane.normal.dot(positions.row(node).transpose() - plane.point);
}

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
      if (!contact.ignored[node])
        force -= evaluate_barrier(gap_to(plane, scene.start_positions, node) - least + gap, contact.distance, stiffness)
                     .slope;
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
        const double gap = gap_to(plane, scene.start_positions, node);
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
