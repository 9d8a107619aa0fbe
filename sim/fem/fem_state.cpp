#include "sim/fem/fem_state.h"

#include <algorithm>

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
    const AlignedVector<double>& points = scene.elements[i]->group().point_rotations;
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
    points[i] = need(path(i, "point_rotations"), scene.elements[i]->group().point_rotations.size());
  }
  if (!missing.empty())
    return make_error(ErrorCode::io, "checkpoint: {} is missing; it was written for another shot", missing);
  state.time = time->values[0];
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i] != nullptr)
      std::copy(points[i]->values.begin(), points[i]->values.end(), scene.elements[i]->group().point_rotations.begin());
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
    out.triangles = geometry::boundary_triangles(*body.mesh);
    scene.bodies.push_back(std::move(out));
  }
  return scene;
}

Frame take_snapshot(const FemScene& scene, const FemState& state, const std::vector<std::vector<double>>& energies,
                    int number) {
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
      out.channels.push_back(
          vertex_channel("microrotation", 4, ChannelStorage::float32, in_mesh_order(state.rotations, body, mesh)));
      out.channels.push_back(
          vertex_channel("angular_velocity", 3, ChannelStorage::float32, in_mesh_order(state.angular, body, mesh)));
    }
    Channel density{"strain_energy_density", ChannelOn::tet, 1, ChannelStorage::float32, {}};
    density.values.resize(energies[i].size());
    for (std::size_t element = 0; element < energies[i].size(); ++element)
      density.values[mesh.tet_of_element[element]] = energies[i][element] / scene.elements[i]->group().volume[element];
    out.channels.push_back(std::move(density));
    frame.bodies.push_back(std::move(out));
  }
  return frame;
}

} // namespace wry::fem
