#include "sim/geometry/closest_point_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace wry::geometry {

namespace {

constexpr std::int32_t LEAF_SIZE = 4;
constexpr int MAX_DEPTH = 60;
/// Of squared distances, relative to those of the points from the origin.
constexpr double ROUNDING = 1e-13;

double squared_distance_to_box(const Vec3& point, const Vec3& low, const Vec3& high) {
  return (low - point).cwiseMax(point - high).cwiseMax(0.0).squaredNorm();
}

/// Barycentric weights of the point of segment ab nearest to p.
double segment_parameter(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double length = (b - a).squaredNorm();
  return length > 0 ? std::clamp((p - a).dot(b - a) / length, 0.0, 1.0) : 0.0;
}

/// Barycentric weights of the point of triangle abc nearest to p; degenerate triangles are treated as their edges.
Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a);
  const double area = normal.squaredNorm();
  if (area > 0) {
    const double wa = (b - p).cross(c - p).dot(normal) / area;
    const double wb = (c - p).cross(a - p).dot(normal) / area;
    const double wc = 1 - wa - wb;
    if (wa >= 0 && wb >= 0 && wc >= 0)
      return {wa, wb, wc};
  }
  const double ab = segment_parameter(p, a, b);
  const double bc = segment_parameter(p, b, c);
  const double ca = segment_parameter(p, c, a);
  const std::array<Vec3, 3> candidates{Vec3(1 - ab, ab, 0), Vec3(0, 1 - bc, bc), Vec3(ca, 0, 1 - ca)};
  double best = std::numeric_limits<double>::infinity();
  Vec3 weights = candidates[0];
  for (const Vec3& candidate : candidates) {
    const double distance = (candidate[0] * a + candidate[1] * b + candidate[2] * c - p).squaredNorm();
    if (distance < best) {
      best = distance;
      weights = candidate;
    }
  }
  return weights;
}

struct HalfEdge {
  std::int32_t low, high, triangle, side;
};

} // namespace

ClosestPointTree::ClosestPointTree(const SurfaceMesh& mesh)
    : m_mesh(mesh) {
  const Eigen::Index count = m_mesh.triangles.rows();
  m_centroids.resize(count, 3);
  m_order.resize(static_cast<std::size_t>(count));
  for (Eigen::Index i = 0; i < count; ++i) {
    m_order[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(i);
    m_centroids.row(i) = (m_mesh.vertices.row(m_mesh.triangles(i, 0)) + m_mesh.vertices.row(m_mesh.triangles(i, 1)) +
                          m_mesh.vertices.row(m_mesh.triangles(i, 2))) /
                         3.0;
  }
  make_normals();
  if (count == 0)
    return;
  m_nodes.reserve(static_cast<std::size_t>(count));
  m_nodes.emplace_back();
  m_nodes[0].end = static_cast<std::int32_t>(count);
  build(0, 0);
  make_leaves();
}

void ClosestPointTree::make_leaves() {
  m_leaves.resize(m_order.size());
  for (std::size_t i = 0; i < m_order.size(); ++i) {
    Leaf& leaf = m_leaves[i];
    for (int k = 0; k < 3; ++k)
      leaf.corner[k] = m_mesh.vertices.row(m_mesh.triangles(m_order[i], k)).transpose();
    leaf.low = leaf.corner[0].cwiseMin(leaf.corner[1]).cwiseMin(leaf.corner[2]);
    leaf.high = leaf.corner[0].cwiseMax(leaf.corner[1]).cwiseMax(leaf.corner[2]);
    leaf.normal = m_face_normals.row(m_order[i]).transpose();
    if (!(std::abs(leaf.normal.norm() - 1.0) < 1e-9))
      leaf.normal.setZero();
  }
}

void ClosestPointTree::build(std::size_t node, int depth) {
  const std::int32_t begin = m_nodes[node].begin;
  const std::int32_t end = m_nodes[node].end;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  Vec3 centre_low = low;
  Vec3 centre_high = high;
  for (std::int32_t i = begin; i < end; ++i) {
    const std::int32_t triangle = m_order[static_cast<std::size_t>(i)];
    for (int k = 0; k < 3; ++k) {
      const Vec3 corner = m_mesh.vertices.row(m_mesh.triangles(triangle, k)).transpose();
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
    const Vec3 centroid = m_centroids.row(triangle).transpose();
    centre_low = centre_low.cwiseMin(centroid);
    centre_high = centre_high.cwiseMax(centroid);
  }
  m_nodes[node].low = low;
  m_nodes[node].high = high;
  if (end - begin <= LEAF_SIZE || depth >= MAX_DEPTH)
    return;
  Eigen::Index axis = 0;
  (centre_high - centre_low).maxCoeff(&axis);
  const std::int32_t middle = begin + (end - begin) / 2;
  std::nth_element(
      m_order.begin() + begin, m_order.begin() + middle, m_order.begin() + end, [&](std::int32_t a, std::int32_t b) {
        return m_centroids(a, axis) != m_centroids(b, axis) ? m_centroids(a, axis) < m_centroids(b, axis) : a < b;
      });
  const std::size_t left = m_nodes.size();
  m_nodes[node].left = static_cast<std::int32_t>(left);
  m_nodes.emplace_back();
  m_nodes.emplace_back();
  m_nodes[left].begin = begin;
  m_nodes[left].end = middle;
  m_nodes[left + 1].begin = middle;
  m_nodes[left + 1].end = end;
  build(left, depth + 1);
  build(left + 1, depth + 1);
}

void ClosestPointTree::make_normals() {
  const Eigen::Index count = m_mesh.triangles.rows();
  m_face_normals = Points::Zero(count, 3);
  m_vertex_normals = Points::Zero(m_mesh.vertices.rows(), 3);
  m_edge_normals = Points::Zero(3 * count, 3);
  std::vector<HalfEdge> edges;
  edges.reserve(static_cast<std::size_t>(3 * count));
  for (std::int32_t i = 0; i < count; ++i) {
    std::array<Vec3, 3> x;
    for (int k = 0; k < 3; ++k)
      x[k] = m_mesh.vertices.row(m_mesh.triangles(i, k)).transpose();
    const Vec3 normal = (x[1] - x[0]).cross(x[2] - x[0]).normalized();
    m_face_normals.row(i) = normal.transpose();
    for (int k = 0; k < 3; ++k) {
      const Vec3 e0 = x[(k + 1) % 3] - x[k];
      const Vec3 e1 = x[(k + 2) % 3] - x[k];
      const double angle = std::atan2(e0.cross(e1).norm(), e0.dot(e1));
      m_vertex_normals.row(m_mesh.triangles(i, k)) += angle * normal.transpose();
      const std::int32_t a = m_mesh.triangles(i, k);
      const std::int32_t b = m_mesh.triangles(i, (k + 1) % 3);
      edges.push_back({std::min(a, b), std::max(a, b), i, k});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::array{a.low, a.high, a.triangle, a.side} < std::array{b.low, b.high, b.triangle, b.side};
  });
  for (std::size_t begin = 0; begin < edges.size();) {
    std::size_t end = begin;
    Vec3 sum = Vec3::Zero();
    for (; end < edges.size() && edges[end].low == edges[begin].low && edges[end].high == edges[begin].high; ++end)
      sum += m_face_normals.row(edges[end].triangle).transpose();
    for (std::size_t i = begin; i < end; ++i)
      m_edge_normals.row(3 * edges[i].triangle + edges[i].side) = sum.normalized().transpose();
    begin = end;
  }
  for (Eigen::Index i = 0; i < m_vertex_normals.rows(); ++i) {
    const double length = m_vertex_normals.row(i).norm();
    if (length > 0)
      m_vertex_normals.row(i) /= length;
  }
}

ClosestPoint ClosestPointTree::closest(const Vec3& point) const {
  return closest_within(point, std::numeric_limits<double>::infinity());
}

void ClosestPointTree::look_at(std::int32_t place, const Vec3& point, Nearest& best) const {
  const Leaf& leaf = m_leaves[static_cast<std::size_t>(place)];
  const auto& [a, b, c] = leaf.corner;
  // Neither its box nor its plane is further than the triangle, but for rounding.
  const double above = leaf.normal.dot(point - a);
  const double least = std::max(above * above, squared_distance_to_box(point, leaf.low, leaf.high));
  if (least > best.squared + ROUNDING * (best.squared + point.squaredNorm() + a.squaredNorm()))
    return;
  const Vec3 weights = closest_on_triangle(point, a, b, c);
  const Vec3 found = weights[0] * a + weights[1] * b + weights[2] * c;
  const double squared = (found - point).squaredNorm();
  const std::int32_t triangle = m_order[static_cast<std::size_t>(place)], so_far = best.closest.triangle;
  if (squared < best.squared || (squared == best.squared && (so_far < 0 || triangle < so_far)))
    best = {{found, triangle, weights, 0.0}, squared};
}

template <class Look>
void ClosestPointTree::for_leaves_within(const Vec3& point, const double& within, const Look& look) const {
  struct Entry {
    std::int32_t node;
    double squared;
  };
  std::array<Entry, MAX_DEPTH + 4> stack;
  std::size_t top = 0;
  stack[top++] = {0, 0.0};
  while (top > 0) {
    const Entry entry = stack[--top];
    if (entry.squared > within)
      continue;
    const Node& node = m_nodes[static_cast<std::size_t>(entry.node)];
    if (node.left >= 0) {
      const Node& a = m_nodes[static_cast<std::size_t>(node.left)];
      const Node& b = m_nodes[static_cast<std::size_t>(node.left) + 1];
      const double da = squared_distance_to_box(point, a.low, a.high);
      const double db = squared_distance_to_box(point, b.low, b.high);
      const Entry first{node.left, da};
      const Entry second{node.left + 1, db};
      const Entry& further = da < db ? second : first;
      const Entry& nearer = da < db ? first : second;
      if (further.squared <= within)
        stack[top++] = further;
      if (nearer.squared <= within)
        stack[top++] = nearer;
      continue;
    }
    for (std::int32_t i = node.begin; i < node.end; ++i)
      look(i);
  }
}

ClosestPoint ClosestPointTree::closest_within(const Vec3& point, double reach) const {
  Nearest best{{}, reach * reach};
  if (m_nodes.empty() || !(reach >= 0.0))
    return best.closest;
  for_leaves_within(point, best.squared, [&](std::int32_t leaf) { look_at(leaf, point, best); });
  best.closest.distance = std::sqrt(best.squared);
  return best.closest;
}

ClosestPoint ClosestPointTree::closest_of(const Vec3& point, std::span<const std::int32_t> leaves) const {
  Nearest best{{}, std::numeric_limits<double>::infinity()};
  for (const std::int32_t leaf : leaves)
    look_at(leaf, point, best);
  best.closest.distance = std::sqrt(best.squared);
  return best.closest;
}

std::vector<std::int32_t> ClosestPointTree::nearest_around(const Vec3& centre, double radius) const {
  std::vector<std::int32_t> leaves;
  const ClosestPoint nearest = closest(centre);
  if (nearest.triangle < 0)
    return leaves;
  // A point of the ball is at most `radius` further from the centre's nearest, and as much nearer to another.
  const double furthest = (nearest.distance + 2.0 * radius) * (1.0 + 1e-9);
  const double squared = furthest * furthest;
  for_leaves_within(centre, squared, [&](std::int32_t place) {
    Nearest one{{}, squared};
    look_at(place, centre, one);
    if (one.closest.triangle >= 0)
      leaves.push_back(place);
  });
  return leaves;
}

Vec3 ClosestPointTree::pseudonormal(const ClosestPoint& closest) const {
  constexpr double ON_EDGE = 1e-9;
  int zeros = 0;
  int last_zero = 0;
  int last_positive = 0;
  for (int k = 0; k < 3; ++k) {
    if (closest.barycentric[k] <= ON_EDGE) {
      ++zeros;
      last_zero = k;
    } else {
      last_positive = k;
    }
  }
  if (zeros == 0)
    return m_face_normals.row(closest.triangle).transpose();
  if (zeros == 1) // the edge opposite to corner k is side k + 1
    return m_edge_normals.row(3 * closest.triangle + (last_zero + 1) % 3).transpose();
  return m_vertex_normals.row(m_mesh.triangles(closest.triangle, last_positive)).transpose();
}

double ClosestPointTree::signed_distance(const Vec3& point) const {
  const ClosestPoint nearest = closest(point);
  if (nearest.triangle < 0)
    return std::numeric_limits<double>::infinity();
  const double side = (point - nearest.point).dot(pseudonormal(nearest));
  return side < 0 ? -nearest.distance : nearest.distance;
}

Vec3 ClosestPointTree::smooth_normal(const ClosestPoint& closest) const {
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < 3; ++k)
    sum += closest.barycentric[k] * m_vertex_normals.row(m_mesh.triangles(closest.triangle, k)).transpose();
  const double length = sum.norm();
  return length > 1e-12 ? Vec3(sum / length) : Vec3(m_face_normals.row(closest.triangle).transpose());
}

} // namespace wry::geometry
