#include "sim/fem/fem_plan.h"

#include <algorithm>
#include <map>

namespace wry::fem {

bool is_micropolar(ElasticModel model) {
  return model == ElasticModel::micropolar || model == ElasticModel::micropolar_det ||
         model == ElasticModel::micropolar_neo_hookean;
}

bool is_plate(ElementKind kind) {
  return kind == ElementKind::plate3 || kind == ElementKind::plate6;
}

bool is_quadratic(ElementKind kind) {
  return kind == ElementKind::tet10 || kind == ElementKind::plate6;
}

namespace {

using Edge = std::array<std::int32_t, 2>;

Edge edge_of(std::int32_t a, std::int32_t b) {
  return {std::min(a, b), std::max(a, b)};
}

/// Adds the edges of elements that are not known yet, in the order in which they are met.
template <class Elements> void add_edges(const Elements& elements, std::map<Edge, int>& known, std::vector<Edge>& out) {
  for (Eigen::Index element = 0; element < elements.rows(); ++element) {
    for (Eigen::Index k = 0; k < elements.cols(); ++k) {
      for (Eigen::Index l = k + 1; l < elements.cols(); ++l) {
        const Edge edge = edge_of(elements(element, k), elements(element, l));
        if (known.try_emplace(edge, static_cast<int>(out.size())).second)
          out.push_back(edge);
      }
    }
  }
}

} // namespace

FemBody with_midpoints(FemBody body) {
  std::map<Edge, int> known;
  add_edges(body.mesh->tets, known, body.edges);
  add_edges(body.triangles, known, body.edges);
  std::shared_ptr<geometry::TetMesh> mesh = std::make_shared<geometry::TetMesh>(*body.mesh);
  const Eigen::Index corners = mesh->vertices.rows();
  const Eigen::Index count = corners + static_cast<Eigen::Index>(body.edges.size());
  const bool own_coordinates = mesh->body_coordinates.rows() > 0;
  mesh->vertices.conservativeResize(count, 3);
  if (own_coordinates)
    mesh->body_coordinates.conservativeResize(count, 2);
  for (geometry::VertexAttribute& attribute : mesh->attributes)
    attribute.values.resize(static_cast<std::size_t>(count * attribute.components));
  for (std::size_t i = 0; i < body.edges.size(); ++i) {
    const auto [a, b] = body.edges[i];
    const Eigen::Index row = corners + static_cast<Eigen::Index>(i);
    mesh->vertices.row(row) = 0.5 * (mesh->vertices.row(a) + mesh->vertices.row(b));
    if (own_coordinates)
      mesh->body_coordinates.row(row) = 0.5 * (mesh->body_coordinates.row(a) + mesh->body_coordinates.row(b));
    for (geometry::VertexAttribute& attribute : mesh->attributes) {
      for (int c = 0; c < attribute.components; ++c)
        attribute.values[static_cast<std::size_t>(row * attribute.components + c)] =
            0.5 * (attribute.values[static_cast<std::size_t>(a * attribute.components + c)] +
                   attribute.values[static_cast<std::size_t>(b * attribute.components + c)]);
    }
  }
  body.mesh = std::move(mesh);
  body.element = is_plate(body.element) ? ElementKind::plate6 : ElementKind::tet10;
  return body;
}

Triangles surface_triangles(const FemBody& body) {
  const Triangles coarse = is_plate(body.element) ? body.triangles : geometry::boundary_triangles(*body.mesh);
  if (body.edges.empty())
    return coarse;
  std::map<Edge, std::int32_t> middle;
  const Eigen::Index corners = body.mesh->vertices.rows() - static_cast<Eigen::Index>(body.edges.size());
  for (std::size_t i = 0; i < body.edges.size(); ++i)
    middle[body.edges[i]] = static_cast<std::int32_t>(corners) + static_cast<std::int32_t>(i);
  Triangles fine(4 * coarse.rows(), 3);
  for (Eigen::Index i = 0; i < coarse.rows(); ++i) {
    std::int32_t corner[3], between[3]; // between[k] lies on the edge from corner k to the next
    for (int k = 0; k < 3; ++k) {
      corner[k] = coarse(i, k);
      between[k] = middle.at(edge_of(coarse(i, k), coarse(i, (k + 1) % 3)));
    }
    for (int k = 0; k < 3; ++k)
      fine.row(4 * i + k) << corner[k], between[k], between[(k + 2) % 3];
    fine.row(4 * i + 3) << between[0], between[1], between[2];
  }
  return fine;
}

} // namespace wry::fem
