#include <algorithm>
#include <array>
#include <numeric>

#include <Eigen/Geometry>

#include "sim/geometry/mesh_checks.h"
#include "sim/geometry/mesh_checks_edges.h"
#include "sim/geometry/mesh_checks_predicates.h"

namespace wry::geometry {

namespace {

struct Box {
  Vec3 lower;
  Vec3 upper;

  bool meets(const Box& other) const {
    return (lower.array() <= other.upper.array()).all() && (other.lower.array() <= upper.array()).all();
  }
};

constexpr std::int32_t LEAF_SIZE = 4;

// Bounding boxes of triangles, halved at the median of the middles along the longest side.
class BoxTree {
public:
  BoxTree(const std::vector<Box>& boxes, std::vector<std::int32_t> members)
      : m_boxes(boxes)
      , m_members(std::move(members)) {
    if (!m_members.empty())
      build(0, static_cast<std::int32_t>(m_members.size()));
  }

  template <class Visit> void query(const Box& box, const Visit& visit) const {
    if (!m_nodes.empty())
      query(0, box, visit);
  }

private:
  struct Node {
    Box box;
    std::int32_t begin;
    std::int32_t end;
    std::int32_t right; // the left child follows its parent; 0: a leaf
  };

  std::int32_t build(std::int32_t begin, std::int32_t end) {
    Box box = m_boxes[m_members[begin]];
    Vec3 low = box.lower + box.upper;
    Vec3 high = low;
    for (std::int32_t i = begin; i < end; ++i) {
      const Box& other = m_boxes[m_members[i]];
      box.lower = box.lower.cwiseMin(other.lower);
      box.upper = box.upper.cwiseMax(other.upper);
      low = low.cwiseMin(other.lower + other.upper);
      high = high.cwiseMax(other.lower + other.upper);
    }
    const auto node = static_cast<std::int32_t>(m_nodes.size());
    m_nodes.push_back({box, begin, end, 0});
    if (end - begin <= LEAF_SIZE)
      return node;
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const std::int32_t middle = begin + (end - begin) / 2;
    std::nth_element(m_members.begin() + begin, m_members.begin() + middle, m_members.begin() + end,
                     [&](std::int32_t a, std::int32_t b) {
                       const double x = m_boxes[a].lower[axis] + m_boxes[a].upper[axis];
                       const double y = m_boxes[b].lower[axis] + m_boxes[b].upper[axis];
                       return x != y ? x < y : a < b;
                     });
    build(begin, middle);
    const std::int32_t right = build(middle, end);
    m_nodes[node].right = right;
    return node;
  }

  template <class Visit> void query(std::int32_t index, const Box& box, const Visit& visit) const {
    const Node& node = m_nodes[index];
    if (!node.box.meets(box))
      return;
    if (node.right == 0) {
      for (std::int32_t i = node.begin; i < node.end; ++i)
        if (m_boxes[m_members[i]].meets(box))
          visit(m_members[i]);
      return;
    }
    query(index + 1, box, visit);
    query(node.right, box, visit);
  }

  const std::vector<Box>& m_boxes;
  std::vector<std::int32_t> m_members;
  std::vector<Node> m_nodes;
};

struct Corners {
  std::array<std::int32_t, 3> index;
  std::array<Vec3, 3> point;
};

Corners corners_of(const SurfaceMesh& mesh, std::int32_t triangle) {
  Corners corners;
  for (int k = 0; k < 3; ++k) {
    corners.index[k] = mesh.triangles(triangle, k);
    corners.point[k] = mesh.vertices.row(corners.index[k]).transpose();
  }
  return corners;
}

// Turns the corners so that those shared with the other triangle come first; returns how many there are.
int shared_first(Corners& corners, const Corners& other) {
  int shared = 0;
  for (int k = 0; k < 3; ++k) {
    if (std::find(other.index.begin(), other.index.end(), corners.index[k]) == other.index.end())
      continue;
    std::swap(corners.index[shared], corners.index[k]);
    std::swap(corners.point[shared], corners.point[k]);
    ++shared;
  }
  return shared;
}

bool meets(Corners a, Corners b) {
  const int shared = shared_first(a, b);
  shared_first(b, a);
  const auto& p = a.point;
  const auto& q = b.point;
  if (shared == 3)
    return false; // duplicates are another flaw
  if (shared == 2)
    return folds_onto(p[0], p[1], p[2], q[2]);
  if (shared == 1)
    return segment_meets_triangle(p[1], p[2], q[0], q[1], q[2]) || segment_meets_triangle(q[1], q[2], p[0], p[1], p[2]);
  for (int k = 0; k < 3; ++k)
    if (segment_meets_triangle(p[k], p[(k + 1) % 3], q[0], q[1], q[2]) ||
        segment_meets_triangle(q[k], q[(k + 1) % 3], p[0], p[1], p[2]))
      return true;
  return false;
}

bool has_area(const Corners& corners) {
  const auto& [a, b, c] = corners.point;
  const double longest = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return a.allFinite() && b.allFinite() && c.allFinite() && (b - a).cross(c - a).norm() > 1e-12 * longest;
}

} // namespace

SelfIntersections find_self_intersections(const SurfaceMesh& mesh, const Threads& threads, std::size_t limit) {
  const std::vector<char> usable = usable_triangles(mesh.triangles, mesh.vertices.rows());
  std::vector<std::int32_t> members;
  std::vector<Box> boxes(usable.size());
  for (std::int32_t t = 0; t < mesh.triangles.rows(); ++t) {
    if (!usable[t])
      continue;
    const Corners corners = corners_of(mesh, t);
    if (!has_area(corners))
      continue;
    const auto& [a, b, c] = corners.point;
    boxes[t] = {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
    members.push_back(t);
  }
  const BoxTree tree(boxes, members);
  constexpr std::size_t GRAIN = 256;
  // In rounds, so that a mesh full of intersections stops early at a place that does not depend on the threads.
  constexpr std::size_t ROUND = GRAIN * 64;
  SelfIntersections found;
  for (std::size_t start = 0; start < members.size(); start += ROUND) {
    if (found.pairs.size() >= limit) {
      found.complete = false;
      break;
    }
    const std::size_t count = std::min(ROUND, members.size() - start);
    std::vector<std::vector<std::pair<std::int32_t, std::int32_t>>> chunks((count + GRAIN - 1) / GRAIN);
    threads.for_chunks(count, GRAIN, [&](std::size_t begin, std::size_t end) {
      auto& pairs = chunks[begin / GRAIN];
      for (std::size_t i = begin; i < end; ++i) {
        const std::int32_t t = members[start + i];
        const Corners corners = corners_of(mesh, t);
        tree.query(boxes[t], [&](std::int32_t other) {
          if (other > t && pairs.size() <= limit && meets(corners, corners_of(mesh, other)))
            pairs.emplace_back(t, other);
        });
      }
      std::sort(pairs.begin(), pairs.end());
    });
    for (const auto& pairs : chunks)
      found.pairs.insert(found.pairs.end(), pairs.begin(), pairs.end());
  }
  if (found.pairs.size() > limit) {
    found.pairs.resize(limit);
    found.complete = false;
  }
  return found;
}

Status check_no_self_intersections(const SurfaceMesh& mesh, const SelfIntersections& found, const std::string& name) {
  if (found.pairs.empty())
    return {};
  const auto [first, second] = found.pairs[0];
  const Corners corners = corners_of(mesh, first);
  const Vec3 at = (corners.point[0] + corners.point[1] + corners.point[2]) / 3;
  return make_error(
      ErrorCode::bad_input,
      "{} cuts or touches itself in {}{} pairs of triangles, the first are {} and {} at ({:.6g}, {:.6g}, {:.6g})", name,
      found.complete ? "" : "at least ", found.pairs.size(), first, second, at.x(), at.y(), at.z());
}

} // namespace wry::geometry
