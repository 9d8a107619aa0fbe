#include "sim/fem/contact_system.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/contact/crossings.h"
#include "sim/contact/pair_boxes.h"

namespace wry::fem {

namespace {

/// Nodes may be this share of the mean edge off their expected ways before candidates are searched again: a search
/// costs as much as looking through some fifteen lists, and longer lists are not much longer.
constexpr double ROOM_SHARE = 0.2;

/// The triangles of a body by its nodes, near to each other in memory where they are near in space.
std::vector<contact::Surface::Triangle> surface_of(const FemBody& body, const OrderedMesh& ordered) {
  std::vector<contact::Surface::Triangle> rows;
  const Triangles triangles = surface_triangles(body);
  for (Eigen::Index i = 0; i < triangles.rows(); ++i) {
    contact::Surface::Triangle row;
    for (int k = 0; k < 3; ++k)
      row[static_cast<std::size_t>(k)] = ordered.node_of_vertex[triangles(i, k)];
    rows.push_back(row);
  }
  std::sort(rows.begin(), rows.end());
  return rows;
}

std::vector<contact::Surface::Triangle> rows_of(const Triangles& triangles) {
  std::vector<contact::Surface::Triangle> rows;
  for (Eigen::Index i = 0; i < triangles.rows(); ++i)
    rows.push_back({triangles(i, 0), triangles(i, 1), triangles(i, 2)});
  return rows;
}

} // namespace

ContactSystem::ContactSystem(const FemPlan& plan, const FemScene& scene, double distance, const Threads& threads,
                             Isa isa)
    : m_plan(plan)
    , m_scene(scene)
    , m_distance(distance)
    , m_threads(threads)
    , m_isa(isa)
    , m_ccd(contact::select_ccd(isa))
    , m_unknown_nodes(scene.model.layout.node_count()) {}

Result<std::unique_ptr<ContactSystem>> ContactSystem::create(const FemPlan& plan, const FemScene& scene,
                                                             double distance, const Threads& threads, Isa isa) {
  if (!plan.contact && plan.obstacles.empty())
    return std::unique_ptr<ContactSystem>();
  std::unique_ptr<ContactSystem> system(new ContactSystem(plan, scene, distance, threads, isa));
  if (Status status = system->add_parts(); !status)
    return status.error();
  system->choose_coefficients();
  if (Status status = system->check_start(); !status)
    return status.error();
  return system;
}

Status ContactSystem::add_parts() {
  const FemModel& model = m_scene.model;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    m_surface.add_part(model.bodies[i].node_count, surface_of(m_plan.bodies[i], m_scene.meshes[i]));
    m_half_thickness.push_back(0.5 * m_plan.bodies[i].thickness);
  }
  double edge = std::numeric_limits<double>::infinity();
  for (const double length : m_scene.edges)
    edge = std::min(edge, length);
  for (const scene::Collider& collider : m_plan.obstacles) {
    Result<geometry::SurfaceMesh> mesh = scene::obstacle_surface(collider.shape, 2.0 * edge);
    if (!mesh)
      return make_error(mesh.error().code, "collider '{}': {}", collider.name, mesh.error().message);
    Obstacle obstacle{&collider, m_surface.node_count(), mesh->vertices};
    std::vector<std::int32_t> loose;
    if (mesh->triangles.rows() == 0) { // points
      for (Eigen::Index vertex = 0; vertex < mesh->vertices.rows(); ++vertex)
        loose.push_back(static_cast<std::int32_t>(vertex));
    }
    std::vector<contact::Surface::Triangle> triangles;
    std::vector<contact::Surface::Edge> segments;
    for (const contact::Surface::Triangle& triangle : rows_of(mesh->triangles)) {
      if (triangle[0] == triangle[1] || triangle[1] == triangle[2]) // an edge, written as a triangle without area
        segments.push_back({triangle[0], triangle[2]});
      else
        triangles.push_back(triangle);
    }
    const int part = m_surface.add_part(static_cast<int>(mesh->vertices.rows()), triangles, segments, loose);
    const auto* sheet = std::get_if<scene::MeshObstacle>(&collider.shape);
    m_half_thickness.push_back(sheet != nullptr && !sheet->closed ? 0.5 * sheet->thickness : 0.0);
    for (std::size_t body = 0; body < model.bodies.size(); ++body)
      m_surface.let_meet(static_cast<int>(body), part);
    m_obstacles.push_back(std::move(obstacle));
  }
  for (int a = 0; m_plan.contact && a < static_cast<int>(model.bodies.size()); ++a) {
    for (int b = a; b < static_cast<int>(model.bodies.size()); ++b) {
      if (a == b ? m_plan.contact->within_bodies : m_plan.contact->between_bodies)
        m_surface.let_meet(a, b);
    }
  }
  for (int a = 0; a < m_surface.part_count(); ++a) {
    for (int b = 0; b < m_surface.part_count(); ++b) {
      if (m_surface.meet(a, b))
        m_most_thickness = std::max(m_most_thickness, m_half_thickness[static_cast<std::size_t>(a)] +
                                                          m_half_thickness[static_cast<std::size_t>(b)]);
    }
  }
  const Eigen::Index obstacle_nodes = m_surface.node_count() - m_unknown_nodes;
  m_obstacle_start.resize(obstacle_nodes, 3);
  m_all.resize(m_surface.node_count(), 3);
  m_all.topRows(m_unknown_nodes) = m_scene.start_positions;
  place_obstacles(0.0);
  m_rest = m_all;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) // before they were lifted off planes
    m_rest.middleRows(model.bodies[i].first_node, model.bodies[i].node_count) = m_scene.meshes[i].mesh.vertices;
  m_edge_squares.reserve(m_surface.edges().size());
  for (const contact::Surface::Edge& e : m_surface.edges())
    m_edge_squares.push_back((m_rest.row(e[1]) - m_rest.row(e[0])).squaredNorm());
  double length = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < m_edge_squares.size() && is_unknown(m_surface.edges()[i][0]); ++i, ++count)
    length += std::sqrt(m_edge_squares[i]);
  m_room = std::max(m_distance, ROOM_SHARE * length / static_cast<double>(std::max<std::size_t>(count, 1)));
  const std::size_t most = std::max<std::size_t>(500'000, 64 * m_surface.edges().size());
  m_broad_phase = std::make_unique<contact::BroadPhase>(
      m_surface, m_threads, most,
      [this](contact::PairKind kind, const std::array<std::int32_t, 4>& nodes) { return rest_limit(kind, nodes); },
      m_isa);
  return {};
}

void ContactSystem::choose_coefficients() {
  const FemModel& model = m_scene.model;
  const std::size_t parts = static_cast<std::size_t>(m_surface.part_count());
  const std::size_t bodies = model.bodies.size();
  m_stiffness.assign(parts * parts, 0.0);
  m_friction.assign(parts * parts, {});
  std::vector<double> elastic(bodies), weight(bodies);
  for (std::size_t i = 0; i < bodies; ++i) {
    const BodyNodes& body = model.bodies[i];
    double mass = 0.0;
    for (int node = body.first_node; node < body.first_node + body.node_count; ++node)
      mass += model.mass[node];
    const double feet = std::max(3.0, std::pow(static_cast<double>(body.node_count), 2.0 / 3.0) / 4.0);
    elastic[i] = m_plan.bodies[i].material.youngs_modulus * m_scene.edges[i];
    weight[i] = mass * m_plan.gravity.norm() / (feet * m_distance);
  }
  const auto friction_of = [&](const std::string& a, const std::string& b) {
    for (const MaterialPair& pair : m_plan.contact->pairs) {
      if ((pair.first == a && pair.second == b) || (pair.first == b && pair.second == a))
        return pair.friction;
    }
    return m_plan.contact->friction;
  };
  for (std::size_t a = 0; a < bodies; ++a) {
    for (std::size_t b = a; b < parts; ++b) {
      const std::size_t index = slot(static_cast<int>(a), static_cast<int>(b));
      // As stiff as the softer one's elements, stiff enough to carry the heavier one.
      const double softer = b < bodies ? std::min(elastic[a], elastic[b]) : elastic[a];
      const double heavier = b < bodies ? std::max(weight[a], weight[b]) : weight[a];
      m_stiffness[index] = m_plan.settings.contact_stiffness.value_or(std::max(softer, heavier));
      if (b >= bodies)
        m_friction[index] = {m_obstacles[b - bodies].collider->friction, m_obstacles[b - bodies].collider->friction};
      else if (m_plan.contact)
        m_friction[index] = friction_of(m_plan.bodies[a].material.name, m_plan.bodies[b].material.name);
    }
  }
  m_least_stiffness = m_stiffness;
}

Status ContactSystem::check_start() {
  const std::vector<contact::Crossing> crossings = contact::find_crossings(m_surface, m_all, m_threads, 1);
  if (!crossings.empty()) {
    const contact::Crossing& first = crossings.front();
    const int a = m_surface.part_of_node(first.edge[0]);
    const int b = m_surface.part_of_node(first.triangle[0]);
    const Vec3 at = 0.5 * (m_all.row(first.edge[0]) + m_all.row(first.edge[1]));
    return make_error(ErrorCode::bad_input,
                      "{} and {} intersect or touch at the start, first near ({:.6g}, {:.6g}, {:.6g}); contact needs a "
                      "gap: move them apart by {:.3g} m or more",
                      part_name(a), a == b ? "itself" : part_name(b), at.x(), at.y(), at.z(), 0.1 * m_distance);
  }
  const double rounding = ROUNDING_UNITS * std::numeric_limits<double>::epsilon() * m_all.cwiseAbs().maxCoeff();
  const Gaps gaps = measure(m_scene.start_positions);
  if (gaps.least < 0.0)
    return check_thickness();
  if (gaps.least <= rounding)
    return make_error(ErrorCode::bad_input,
                      "the least gap at the start is {:.3g} m, which rounding of positions (about {:.3g} m) could "
                      "close; move what is so near apart by {:.3g} m or more",
                      gaps.least, rounding, 0.1 * m_distance);
  return {};
}

/// Names the first pair that is nearer than it is thick.
Status ContactSystem::check_thickness() const {
  for (const ContactPair& pair : m_pairs) {
    const double gap = std::sqrt(contact::squared_distance(pair.kind, points_of(pair))) - pair.thickness;
    if (gap >= 0.0)
      continue;
    const Vec3 at = points_of(pair).row(0);
    return make_error(ErrorCode::bad_input,
                      "{} and {} are together {:.3g} m thick, but {:.3g} m nearer than that at the start, near "
                      "({:.6g}, {:.6g}, {:.6g}); move them apart, or make them thinner",
                      part_name(pair.parts[0]), pair.parts[0] == pair.parts[1] ? "itself" : part_name(pair.parts[1]),
                      pair.thickness, -gap, at.x(), at.y(), at.z());
  }
  return {};
}

} // namespace wry::fem
