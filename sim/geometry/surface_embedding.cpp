#include "sim/geometry/surface_embedding.h"

#include <algorithm>

#include <Eigen/LU>

#include "sim/geometry/closest_point_tree.h"

namespace wry::geometry {

namespace {

constexpr std::size_t GRAIN = 512;

std::size_t at(Eigen::Index i) {
  return static_cast<std::size_t>(i);
}

Mat3 edges_of(const Points& positions, const Tets& tets, Eigen::Index tet) {
  Mat3 edges;
  for (int k = 0; k < 3; ++k)
    edges.col(k) = (positions.row(tets(tet, k + 1)) - positions.row(tets(tet, 0))).transpose();
  return edges;
}

} // namespace

SurfaceEmbedding SurfaceEmbedding::make(const TetMesh& mesh, const Points& points) {
  SurfaceEmbedding embedding;
  embedding.m_rest_points = points;
  embedding.m_rest_vertices = mesh.vertices;
  embedding.m_tets = mesh.tets;
  embedding.m_tets_of_begin.assign(at(mesh.vertices.rows()) + 1, 0);
  for (Eigen::Index i = 0; i < mesh.tets.size(); ++i)
    ++embedding.m_tets_of_begin[at(mesh.tets.data()[i]) + 1];
  for (std::size_t v = 1; v < embedding.m_tets_of_begin.size(); ++v)
    embedding.m_tets_of_begin[v] += embedding.m_tets_of_begin[v - 1];
  embedding.m_tets_of.resize(at(mesh.tets.size()));
  std::vector<std::int32_t> next(embedding.m_tets_of_begin.begin(), embedding.m_tets_of_begin.end() - 1);
  for (std::int32_t t = 0; t < mesh.tets.rows(); ++t) {
    const Mat3 edges = edges_of(mesh.vertices, mesh.tets, t);
    embedding.m_inverse_edges.push_back(edges.inverse());
    embedding.m_volumes.push_back(edges.determinant() / 6);
    for (int k = 0; k < 4; ++k)
      embedding.m_tets_of[at(next[at(mesh.tets(t, k))]++)] = t;
  }
  const ClosestPointTree boundary({mesh.vertices, boundary_triangles(mesh), {}});
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Vec3 point = points.row(i).transpose();
    const ClosestPoint nearest = boundary.closest(point);
    std::int32_t best = 0;
    Vec4 best_weights = Vec4::Constant(-1e300);
    // Among the tets around the nearest boundary triangle, the one that holds the point, or least fails to.
    for (int k = 0; k < 3; ++k) {
      const std::int32_t vertex = boundary.mesh().triangles(nearest.triangle, k);
      for (std::int32_t j = embedding.m_tets_of_begin[at(vertex)]; j < embedding.m_tets_of_begin[at(vertex) + 1]; ++j) {
        const std::int32_t tet = embedding.m_tets_of[at(j)];
        const Vec3 local =
            embedding.m_inverse_edges[at(tet)] * (point - mesh.vertices.row(mesh.tets(tet, 0)).transpose());
        const Vec4 weights(1 - local.sum(), local[0], local[1], local[2]);
        if (weights.minCoeff() > best_weights.minCoeff()) {
          best = tet;
          best_weights = weights;
        }
      }
    }
    embedding.m_tet.push_back(best);
    embedding.m_weights.push_back(best_weights);
  }
  return embedding;
}

std::vector<Mat3> SurfaceEmbedding::corner_gradients(const Points& positions, const Threads& threads) const {
  std::vector<Mat3> of_tet(at(m_tets.rows()));
  threads.for_each(of_tet.size(), GRAIN, [&](std::size_t t) {
    of_tet[t] = edges_of(positions, m_tets, static_cast<Eigen::Index>(t)) * m_inverse_edges[t];
  });
  std::vector<Mat3> of_vertex(at(m_rest_vertices.rows()));
  threads.for_each(of_vertex.size(), GRAIN, [&](std::size_t v) {
    Mat3 sum = Mat3::Zero();
    double volume = 0;
    for (std::int32_t j = m_tets_of_begin[v]; j < m_tets_of_begin[v + 1]; ++j) {
      const std::size_t tet = at(m_tets_of[at(j)]);
      sum += m_volumes[tet] * of_tet[tet];
      volume += m_volumes[tet];
    }
    of_vertex[v] = volume > 0 ? Mat3(sum / volume) : Mat3(Mat3::Identity());
  });
  return of_vertex;
}

Points SurfaceEmbedding::deform(const Points& positions, const Threads& threads) const {
  const std::vector<Mat3> gradients = corner_gradients(positions, threads);
  Points points(m_rest_points.rows(), 3);
  threads.for_each(at(points.rows()), GRAIN, [&](std::size_t i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Vec3 rest = m_rest_points.row(row).transpose();
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < 4; ++k) {
      const std::int32_t vertex = m_tets(m_tet[i], k);
      const Vec3 offset = rest - m_rest_vertices.row(vertex).transpose();
      sum += m_weights[i][k] * (positions.row(vertex).transpose() + 0.5 * gradients[at(vertex)] * offset);
    }
    points.row(row) = sum.transpose();
  });
  return points;
}

std::vector<double> SurfaceEmbedding::interpolate(const std::vector<double>& values, int components) const {
  const std::size_t width = at(components);
  std::vector<double> carried(m_tet.size() * width, 0.0);
  for (std::size_t i = 0; i < m_tet.size(); ++i) {
    for (int k = 0; k < 4; ++k) {
      const double* corner = values.data() + at(m_tets(m_tet[i], k)) * width;
      for (std::size_t c = 0; c < width; ++c)
        carried[i * width + c] += m_weights[i][k] * corner[c];
    }
  }
  return carried;
}

SurfaceEmbedding::Farthest SurfaceEmbedding::farthest() const {
  Farthest farthest;
  for (Eigen::Index i = 0; i < m_rest_points.rows(); ++i) {
    const std::size_t tet = at(m_tet[at(i)]);
    const Mat3& gradients = m_inverse_edges[tet]; // rows: of the weights of corners 1 to 3
    double distance = 0.0;
    for (int k = 0; k < 4; ++k) {
      const Vec3 gradient =
          k == 0 ? Vec3(-gradients.colwise().sum().transpose()) : Vec3(gradients.row(k - 1).transpose());
      distance = std::max(distance, -m_weights[at(i)][k] / gradient.norm());
    }
    if (distance <= farthest.distance)
      continue;
    double edge = 0.0;
    for (int a = 0; a < 4; ++a) {
      for (int b = a + 1; b < 4; ++b)
        edge = std::max(
            edge, (m_rest_vertices.row(m_tets(m_tet[at(i)], a)) - m_rest_vertices.row(m_tets(m_tet[at(i)], b))).norm());
    }
    farthest = {distance, edge, m_rest_points.row(i).transpose()};
  }
  return farthest;
}

} // namespace wry::geometry
