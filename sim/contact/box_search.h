#pragma once

#include <vector>

#include "sim/base/parallel.h"
#include "sim/contact/box_tree.h"
#include "sim/contact/candidate_pair.h"
#include "sim/contact/surface.h"

namespace wry::contact {

/// Finds the primitives whose boxes, which move, come within a distance.
template <class T> class BoxSearch {
public:
  using AnyBox = MovingBoxOf<T>;

  BoxSearch(const Surface& surface, const Threads& threads, FindInTree<T> find_in_tree);

  /// Boxes of primitives are around those of their nodes, one per node of the surface. Pairs will be of this group and
  /// within this distance [m].
  void update(const std::vector<AnyBox>& nodes, PairGroup group, double distance);

  /// Adds the triangles near points [begin, end), in no order: all by their places in the surface.
  void add_triangles(std::int32_t begin, std::int32_t end, std::vector<CandidatePair>& out) const;
  /// Adds the edges near edges [begin, end) and beyond each, in no order.
  void add_edges(std::int32_t begin, std::int32_t end, std::vector<CandidatePair>& out) const;

  std::size_t memory_bytes() const;

private:
  void find_partners(PairGroup group);
  template <class PairOf>
  void find(const TreeOf<AnyBox>& tree, const TreeQuery<T>& query, std::vector<CandidatePair>& out,
            const PairOf& pair_of) const;

  const Surface& m_surface;
  const Threads& m_threads;
  FindInTree<T> m_find_in_tree;
  std::vector<std::size_t> m_first_point, m_first_edge, m_first_triangle; ///< per part, and one past the last
  const std::vector<AnyBox>* m_nodes = nullptr;
  double m_distance = 0.0;
  std::vector<AnyBox> m_triangle_boxes, m_edge_boxes;
  std::vector<TreeOf<AnyBox>> m_triangle_trees, m_edge_trees; ///< per part
  std::vector<std::vector<int>> m_partners;                   ///< per part: those it can meet now
};

/// Where the points of each part begin in the surface, and one past the last.
std::vector<std::size_t> first_points_of_parts(const Surface& surface);

extern template class BoxSearch<float>;
extern template class BoxSearch<double>;

} // namespace wry::contact
