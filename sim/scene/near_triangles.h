#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "sim/geometry/closest_point_tree.h"
#include "sim/scene/cubes.h"

namespace wry::scene {

/// Closest points of a mesh by cubes of space: which triangles may be nearest to a point of a cube is worked out when
/// it is first asked for and kept. The same answers, bit for bit, as the tree's. Queries may run on many threads.
class NearTriangles {
public:
  /// The tree must outlive this. 8 bytes per cube, and the lists of those that were asked for.
  NearTriangles(const geometry::ClosestPointTree& tree, const Cubes& cubes);
  ~NearTriangles();
  NearTriangles(const NearTriangles&) = delete;
  NearTriangles& operator=(const NearTriangles&) = delete;

  geometry::ClosestPoint closest(const Vec3& point) const;

private:
  using List = std::vector<std::int32_t>;
  const List& list_of(const Cubes::Place& place) const;

  const geometry::ClosestPointTree& m_tree;
  Cubes m_cubes;
  mutable std::unique_ptr<std::atomic<const List*>[]> m_lists;
};

} // namespace wry::scene
