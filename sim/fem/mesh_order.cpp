#include "sim/fem/mesh_order.h"

#include <algorithm>
#include <numeric>

namespace wry::fem {

namespace {

using Graph = std::vector<std::vector<std::int32_t>>;

/// `elements`: `per_element` vertices each.
Graph vertex_graph(Eigen::Index vertices, int per_element, const std::vector<std::int32_t>& elements) {
  Graph graph(static_cast<std::size_t>(vertices));
  for (auto first = elements.begin(); first != elements.end(); first += per_element) {
    for (int k = 0; k < per_element; ++k) {
      for (int l = 0; l < per_element; ++l) {
        if (k != l)
          graph[first[k]].push_back(first[l]);
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

OrderedMesh order_for_locality(const Points& vertices, int per_element, std::vector<std::int32_t>& elements) {
  OrderedMesh ordered;
  ordered.vertex_of_node = reverse_cuthill_mckee(vertex_graph(vertices.rows(), per_element, elements));
  ordered.node_of_vertex.resize(ordered.vertex_of_node.size());
  ordered.mesh.vertices.resize(vertices.rows(), 3);
  for (std::size_t node = 0; node < ordered.vertex_of_node.size(); ++node) {
    ordered.node_of_vertex[ordered.vertex_of_node[node]] = static_cast<std::int32_t>(node);
    ordered.mesh.vertices.row(static_cast<Eigen::Index>(node)) = vertices.row(ordered.vertex_of_node[node]);
  }
  const std::size_t count = elements.size() / static_cast<std::size_t>(per_element);
  std::vector<std::vector<std::int32_t>> keys(count), renumbered(count);
  for (std::size_t element = 0; element < count; ++element) {
    for (int k = 0; k < per_element; ++k)
      keys[element].push_back(ordered.node_of_vertex[elements[element * per_element + k]]);
    renumbered[element] = keys[element];
    std::sort(keys[element].begin(), keys[element].end());
  }
  ordered.tet_of_element.resize(count);
  std::iota(ordered.tet_of_element.begin(), ordered.tet_of_element.end(), 0);
  std::stable_sort(ordered.tet_of_element.begin(), ordered.tet_of_element.end(),
                   [&](std::int32_t a, std::int32_t b) { return keys[a] < keys[b]; });
  for (std::size_t element = 0; element < count; ++element)
    std::copy_n(renumbered[ordered.tet_of_element[element]].begin(), per_element,
                elements.begin() + static_cast<std::ptrdiff_t>(element * per_element));
  return ordered;
}

OrderedMesh order_for_locality(const geometry::TetMesh& mesh) {
  std::vector<std::int32_t> elements(mesh.tets.data(), mesh.tets.data() + mesh.tets.size());
  OrderedMesh ordered = order_for_locality(mesh.vertices, 4, elements);
  ordered.mesh.tets = Eigen::Map<const Tets>(elements.data(), mesh.tets.rows(), 4);
  return ordered;
}

} // namespace wry::fem
