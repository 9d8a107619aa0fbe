#include "sim/fem/mesh_order.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace wry::fem {

namespace {

using Graph = std::vector<std::vector<std::int32_t>>;

Graph vertex_graph(const geometry::TetMesh& mesh) {
  Graph graph(mesh.vertices.rows());
  for (Eigen::Index tet = 0; tet < mesh.tets.rows(); ++tet) {
    for (int k = 0; k < 4; ++k) {
      for (int l = 0; l < 4; ++l) {
        if (k != l)
          graph[mesh.tets(tet, k)].push_back(mesh.tets(tet, l));
      }
    }
  }
  for (std::vector<std::int32_t>& row : graph) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
  }
  return graph;
}

/// Appends the component of `start`, breadth first, neighbours by rising degree.
void walk(const Graph& graph, std::int32_t start, std::vector<char>& seen, std::vector<std::int32_t>& order) {
  std::size_t next = order.size();
  order.push_back(start);
  seen[start] = 1;
  while (next < order.size()) {
    std::vector<std::int32_t> fresh;
    for (const std::int32_t neighbour : graph[order[next++]]) {
      if (!seen[neighbour]) {
        seen[neighbour] = 1;
        fresh.push_back(neighbour);
      }
    }
    std::stable_sort(fresh.begin(), fresh.end(),
                     [&](std::int32_t a, std::int32_t b) { return graph[a].size() < graph[b].size(); });
    order.insert(order.end(), fresh.begin(), fresh.end());
  }
}

/// A vertex at an end of the component: the last one of a walk from anywhere, twice.
std::int32_t end_of_component(const Graph& graph, std::int32_t start) {
  for (int round = 0; round < 2; ++round) {
    std::vector<char> seen(graph.size(), 0);
    std::vector<std::int32_t> order;
    walk(graph, start, seen, order);
    start = order.back();
  }
  return start;
}

std::vector<std::int32_t> reverse_cuthill_mckee(const Graph& graph) {
  std::vector<char> seen(graph.size(), 0);
  std::vector<std::int32_t> order;
  order.reserve(graph.size());
  int long_components = 0;
  for (std::size_t vertex = 0; vertex < graph.size(); ++vertex) {
    if (seen[vertex])
      continue;
    // Each search for an end costs a walk over all flags: worth it for a few components, not for thousands.
    const bool search = ++long_components <= 64;
    walk(graph, search ? end_of_component(graph, static_cast<std::int32_t>(vertex)) : static_cast<std::int32_t>(vertex),
         seen, order);
  }
  std::reverse(order.begin(), order.end());
  return order;
}

} // namespace

OrderedMesh order_for_locality(const geometry::TetMesh& mesh) {
  OrderedMesh ordered;
  ordered.vertex_of_node = reverse_cuthill_mckee(vertex_graph(mesh));
  ordered.node_of_vertex.resize(ordered.vertex_of_node.size());
  ordered.mesh.vertices.resize(mesh.vertices.rows(), 3);
  for (std::size_t node = 0; node < ordered.vertex_of_node.size(); ++node) {
    ordered.node_of_vertex[ordered.vertex_of_node[node]] = static_cast<std::int32_t>(node);
    ordered.mesh.vertices.row(static_cast<Eigen::Index>(node)) = mesh.vertices.row(ordered.vertex_of_node[node]);
  }
  std::vector<std::array<std::int32_t, 4>> keys(mesh.tets.rows());
  for (Eigen::Index tet = 0; tet < mesh.tets.rows(); ++tet) {
    for (int k = 0; k < 4; ++k)
      keys[tet][k] = ordered.node_of_vertex[mesh.tets(tet, k)];
    std::sort(keys[tet].begin(), keys[tet].end());
  }
  ordered.tet_of_element.resize(mesh.tets.rows());
  std::iota(ordered.tet_of_element.begin(), ordered.tet_of_element.end(), 0);
  std::stable_sort(ordered.tet_of_element.begin(), ordered.tet_of_element.end(),
                   [&](std::int32_t a, std::int32_t b) { return keys[a] < keys[b]; });
  ordered.mesh.tets.resize(mesh.tets.rows(), 4);
  for (Eigen::Index element = 0; element < mesh.tets.rows(); ++element) {
    for (int k = 0; k < 4; ++k)
      ordered.mesh.tets(element, k) = ordered.node_of_vertex[mesh.tets(ordered.tet_of_element[element], k)];
  }
  return ordered;
}

} // namespace wry::fem
