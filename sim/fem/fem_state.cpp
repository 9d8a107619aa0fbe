#include "sim/fem/fem_state.h"

#include <algorithm>
#include <array>

#include "sim/base/rotation.h"
#include "sim/geometry/tet_mesh.h"

namespace wry::fem {

namespace {

/// Rows of one body, from the solver's order to the mesh's.
template <class Rows>
std::vector<double> in_mesh_order(const Rows& rows, const BodyNodes& body, const OrderedMesh& mesh) {
  const std::size_t columns = static_cast<std::size_t>(rows.cols());
  std::vector<double> out(static_cast<std::size_t>(body.node_count) * columns);
  for (int node = 0; node < body.node_count; ++node)
    std::copy_n(rows.data() + static_cast<std::size_t>(body.first_node + node) * columns, columns,
                out.data() + static_cast<std::size_t>(mesh.vertex_of_node[node]) * columns);
  return out;
}

template <class Rows>
void from_mesh_order(const std::vector<double>& in, const BodyNodes& body, const OrderedMesh& mesh, Rows& rows) {
  const std::size_t columns = static_cast<std::size_t>(rows.cols());
  for (int node = 0; node < body.node_count; ++node)
    std::copy_n(in.data() + static_cast<std::size_t>(mesh.vertex_of_node[node]) * columns, columns,
                rows.data() + static_cast<std::size_t>(body.first_node + node) * columns);
}

std::string path(std::size_t body, const char* field) {
  return fmt::format("fem/body{}/{}", body, field);
}

Channel vertex_channel(const char* name, int components, ChannelStorage storage, std::vector<double> values) {
  return {name, ChannelOn::vertex, components, storage, std::move(values)};
}

} // namespace

RotationHistory::RotationHistory(const Quaternions& rotations,
                                 const std::vector<std::unique_ptr<BodyElements>>& elements)
    : m_rotations(rotations) {
  for (const std::unique_ptr<BodyElements>& body : elements)
    m_points.emplace_back(body->point_rotations().begin(), body->point_rotations().end());
}

void RotationHistory::restore(Quaternions& rotations,
                              const std::vector<std::unique_ptr<BodyElements>>& elements) const {
  if (m_points.empty())
    return;
  rotations = m_rotations;
  for (std::size_t body = 0; body < elements.size(); ++body)
    std::copy(m_points[body].begin(), m_points[body].end(), elements[body]->point_rotations().begin());
}

FemState initial_state(const FemPlan& plan, const FemScene& scene) {
  const FemModel& model = scene.model;
  FemState state;
  state.positions = scene.start_positions;
  state.velocities = Points::Zero(model.layout.node_count(), 3);
  for (std::size_t i = 0; i < plan.bodies.size(); ++i)
    state.velocities.middleRows(model.bodies[i].first_node, model.bodies[i].node_count).rowwise() =
        plan.bodies[i].initial_velocity.transpose();
  if (model.any_micropolar) {
    state.angular = Points::Zero(model.layout.node_count(), 3);
    state.rotations = Quaternions::Zero(model.layout.node_count(), 4);
    state.rotations.col(0).setOnes();
  }
  return state;
}

StateArchive archive_state(const FemScene& scene, const FemState& state) {
  StateArchive archive;
  archive.push_back({"fem/time", {1}, {state.time}});
  for (std::size_t i = 0; i < scene.model.bodies.size(); ++i) {
    const BodyNodes& body = scene.model.bodies[i];
    const OrderedMesh& mesh = scene.meshes[i];
    const std::size_t count = static_cast<std::size_t>(body.node_count);
    archive.push_back({path(i, "positions"), {count, 3}, in_mesh_order(state.positions, body, mesh)});
    archive.push_back({path(i, "velocities"), {count, 3}, in_mesh_order(state.velocities, body, mesh)});
    if (!body.micropolar)
      continue;
    archive.push_back({path(i, "angular_velocities"), {count, 3}, in_mesh_order(state.angular, body, mesh)});
    archive.push_back({path(i, "rotations"), {count, 4}, in_mesh_order(state.rotations, body, mesh)});
    const std::span<const double> points = scene.elements[i]->point_rotations();
    archive.push_back({path(i, "point_rotations"), {points.size()}, std::vector<double>(points.begin(), points.end())});
  }
  return archive;
}

const NamedArray* find_array(const StateArchive& archive, std::string_view name, std::size_t entries) {
  for (const NamedArray& array : archive) {
    if (array.name == name && array.values.size() == entries)
      return &array;
  }
  return nullptr;
}

Status restore_state(const StateArchive& archive, FemScene& scene, FemState& state) {
  std::string missing;
  const auto need = [&](const std::string& name, std::size_t entries) -> const NamedArray* {
    const NamedArray* array = find_array(archive, name, entries);
    if (array == nullptr && missing.empty())
      missing = fmt::format("{} with {} entries", name, entries);
    return array;
  };
  const NamedArray* time = need("fem/time", 1);
  std::vector<const NamedArray*> points(scene.model.bodies.size(), nullptr);
  for (std::size_t i = 0; i < scene.model.bodies.size(); ++i) {
    const BodyNodes& body = scene.model.bodies[i];
    const OrderedMesh& mesh = scene.meshes[i];
    const std::size_t count = static_cast<std::size_t>(body.node_count);
    if (const NamedArray* array = need(path(i, "positions"), 3 * count))
      from_mesh_order(array->values, body, mesh, state.positions);
    if (const NamedArray* array = need(path(i, "velocities"), 3 * count))
      from_mesh_order(array->values, body, mesh, state.velocities);
    if (!body.micropolar)
      continue;
    if (const NamedArray* array = need(path(i, "angular_velocities"), 3 * count))
      from_mesh_order(array->values, body, mesh, state.angular);
    if (const NamedArray* array = need(path(i, "rotations"), 4 * count))
      from_mesh_order(array->values, body, mesh, state.rotations);
    points[i] = need(path(i, "point_rotations"), scene.elements[i]->point_rotations().size());
  }
  if (!missing.empty())
    return make_error(ErrorCode::io, "checkpoint: {} is missing; it was written for another shot", missing);
  state.time = time->values[0];
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i] != nullptr)
      std::copy(points[i]->values.begin(), points[i]->values.end(), scene.elements[i]->point_rotations().begin());
  }
  return {};
}

SceneStatic describe_bodies(const FemPlan& plan) {
  SceneStatic scene;
  for (const FemBody& body : plan.bodies) {
    SceneBody out;
    out.name = body.name;
    out.rest_positions = body.mesh->vertices;
    out.tets = body.mesh->tets;
    out.triangles = surface_triangles(body);
    scene.bodies.push_back(std::move(out));
  }
  return scene;
}

namespace {

/// Microrotations of a body in the order of the mesh, with the directors' own rotation at rest.
std::vector<double> directors(const FemBody& body, std::vector<double> rotations) {
  for (std::size_t vertex = 0; vertex < body.vertex_rest_rotations.size(); ++vertex) {
    Eigen::Map<Vec4> q(rotations.data() + 4 * vertex);
    q = quaternion_product(q, body.vertex_rest_rotations[vertex]);
  }
  return rotations;
}

/// 4 x 4 per tet, in the order of the mesh: point k lies near corner k of the tet.
Channel point_rotation_channel(const ElementGroup& group, const geometry::TetMesh& original, const OrderedMesh& mesh) {
  Channel channel{"point_rotation", ChannelOn::tet, 16, ChannelStorage::float64, {}};
  channel.values.resize(static_cast<std::size_t>(group.element_count) * 16);
  for (int element = 0; element < group.element_count; ++element) {
    const int tet = mesh.tet_of_element[element];
    std::array<std::int32_t, 4> corners{};
    for (int k = 0; k < 4; ++k)
      corners[k] = mesh.node_of_vertex[original.tets(tet, k)];
    for (int k = 0; k < 4; ++k) {
      // Points of an element stand in the order of its nodes, which ascend.
      const auto point = std::count_if(corners.begin(), corners.end(), [&](int other) { return other < corners[k]; });
      for (int i = 0; i < 4; ++i)
        channel.values[static_cast<std::size_t>(tet) * 16 + 4 * k + i] =
            group.point_rotations[(static_cast<std::size_t>(element / LANES) * 16 + 4 * point + i) * LANES +
                                  element % LANES];
    }
  }
  return channel;
}

} // namespace

void add_energy_density(const char* name, const FemScene& scene, std::size_t body, const std::vector<double>& energies,
                        Frame& frame) {
  if (scene.model.bodies[body].plate) // has no tets
    return;
  Channel density{name, ChannelOn::tet, 1, ChannelStorage::float32, {}};
  density.values.resize(energies.size());
  for (std::size_t element = 0; element < energies.size(); ++element)
    density.values[scene.meshes[body].tet_of_element[element]] =
        energies[element] / scene.elements[body]->element_volume(static_cast<int>(element));
  frame.bodies[body].channels.push_back(std::move(density));
}

void add_reactions(const FemScene& scene, const Points& forces, const Points& torques, Frame& frame) {
  const int count = scene.model.layout.node_count();
  for (std::size_t i = 0; i < scene.model.bodies.size(); ++i) {
    const BodyNodes& body = scene.model.bodies[i];
    const OrderedMesh& mesh = scene.meshes[i];
    const Points none = Points::Zero(count, 3);
    std::vector<Channel>& channels = frame.bodies[i].channels;
    channels.push_back(vertex_channel("reaction_force", 3, ChannelStorage::float64,
                                      in_mesh_order(forces.rows() > 0 ? forces : none, body, mesh)));
    channels.push_back(vertex_channel("reaction_torque", 3, ChannelStorage::float64,
                                      in_mesh_order(torques.rows() > 0 ? torques : none, body, mesh)));
  }
}

Frame take_snapshot(const FemPlan& plan, const FemScene& scene, const FemState& state,
                    const std::vector<std::vector<double>>& energies, int number) {
  Frame frame;
  frame.number = number;
  frame.time = state.time;
  for (std::size_t i = 0; i < scene.model.bodies.size(); ++i) {
    const BodyNodes& body = scene.model.bodies[i];
    const OrderedMesh& mesh = scene.meshes[i];
    FrameBody out;
    out.name = body.name;
    out.channels.push_back(
        vertex_channel("position", 3, ChannelStorage::float64, in_mesh_order(state.positions, body, mesh)));
    out.channels.push_back(
        vertex_channel("velocity", 3, ChannelStorage::float32, in_mesh_order(state.velocities, body, mesh)));
    if (body.micropolar) {
      out.channels.push_back(vertex_channel(
          "microrotation", 4, plan.outputs.point_rotations ? ChannelStorage::float64 : ChannelStorage::float32,
          directors(plan.bodies[i], in_mesh_order(state.rotations, body, mesh))));
      if (const ElementGroup* group = scene.elements[i]->tet_group(); group != nullptr && plan.outputs.point_rotations)
        out.channels.push_back(point_rotation_channel(*group, *plan.bodies[i].mesh, mesh));
      out.channels.push_back(
          vertex_channel("angular_velocity", 3, ChannelStorage::float32, in_mesh_order(state.angular, body, mesh)));
    }
    frame.bodies.push_back(std::move(out));
    add_energy_density("strain_energy_density", scene, i, energies[i], frame);
  }
  return frame;
}

} // namespace wry::fem
