#include "sim/scene/near_triangles.h"

namespace wry::scene {

NearTriangles::NearTriangles(const geometry::ClosestPointTree& tree, const Cubes& cubes)
    : m_tree(tree)
    , m_cubes(cubes)
    , m_lists(std::make_unique<std::atomic<const List*>[]>(static_cast<std::size_t>(cubes.count()))) {}

NearTriangles::~NearTriangles() {
  for (std::int64_t i = 0; i < m_cubes.count(); ++i)
    delete m_lists[static_cast<std::size_t>(i)].load(std::memory_order_relaxed);
}

const NearTriangles::List& NearTriangles::list_of(const Cubes::Place& place) const {
  std::atomic<const List*>& kept = m_lists[static_cast<std::size_t>(place.cube)];
  if (const List* list = kept.load(std::memory_order_acquire))
    return *list;
  auto made = std::make_unique<const List>(m_tree.nearest_around(place.centre, m_cubes.radius()));
  const List* first = nullptr;
  if (kept.compare_exchange_strong(first, made.get(), std::memory_order_acq_rel))
    return *made.release();
  return *first; // another thread was faster
}

geometry::ClosestPoint NearTriangles::closest(const Vec3& point) const {
  constexpr std::size_t MOST = 32; // beyond which the tree is faster
  const Cubes::Place place = m_cubes.find(point);
  if (place.cube < 0)
    return m_tree.closest(point);
  const List& list = list_of(place);
  return list.size() <= MOST ? m_tree.closest_of(point, list) : m_tree.closest(point);
}

} // namespace wry::scene
