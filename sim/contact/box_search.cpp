#include "sim/contact/box_search.h"

#include <algorithm>
#include <array>

namespace wry::contact {

namespace {

constexpr std::size_t BOX_GRAIN = 2048;

bool share_node(const Surface::Edge& a, const Surface::Edge& b) {
  bool shared = a[0] == b[0];
  shared |= a[0] == b[1];
  shared |= a[1] == b[0];
  shared |= a[1] == b[1];
  return shared;
}

bool has_node(const Surface::Triangle& triangle, std::int32_t node) {
  bool found = triangle[0] == node;
  found |= triangle[1] == node;
  found |= triangle[2] == node;
  return found;
}

/// Where the primitives of each part begin: they come part by part.
template <class Primitives, class NodeOf>
std::vector<std::size_t> first_of_parts(const Surface& surface, const Primitives& primitives, const NodeOf& node_of) {
  std::vector<std::size_t> first(static_cast<std::size_t>(surface.part_count()) + 1, 0);
  for (const auto& primitive : primitives)
    ++first[static_cast<std::size_t>(surface.part_of_node(node_of(primitive))) + 1];
  for (std::size_t part = 1; part < first.size(); ++part)
    first[part] += first[part - 1];
  return first;
}

template <class Primitive, class AnyBox>
void put_boxes(const std::vector<Primitive>& primitives, const std::vector<AnyBox>& nodes, const Threads& threads,
               std::vector<AnyBox>& out) {
  out.resize(primitives.size());
  threads.for_each(primitives.size(), BOX_GRAIN, [&](std::size_t i) {
    out[i] = nodes[primitives[i][0]];
    for (std::size_t k = 1; k < primitives[i].size(); ++k)
      out[i].include(nodes[primitives[i][k]]);
  });
}

/// The sides of a box, and how they grow.
template <class T> T size_of(const MovingBoxOf<T>& box) {
  return (box.high - box.low + box.way_high - box.way_low).sum();
}

/// Boxes of primitives that follow each other, as long as they are near each other.
template <class T> class QueryGroup {
public:
  QueryGroup() {
    for (MovingBoxes<T>& boxes : query.boxes)
      clear(boxes);
  }
  /// False where the box is too far away, or there are too many.
  bool add(const MovingBoxOf<T>& box, std::int32_t after) {
    MovingBoxOf<T> around = query.count > 0 ? m_around : box;
    around.include(box);
    if (query.count == MOST_ASKERS || (query.count > 0 && size_of(around) > LOOSENESS * m_size))
      return false;
    m_around = around;
    m_size = std::max(m_size, size_of(box));
    put(query.boxes[query.count / 4], query.count % 4, box);
    query.after[query.count++] = after;
    for (int i = 0; i < 3; ++i) {
      query.low[i] = around.low[i];
      query.high[i] = around.high[i];
      query.way_low[i] = around.way_low[i];
      query.way_high[i] = around.way_high[i];
    }
    return true;
  }

  TreeQuery<T> query;

private:
  static constexpr T LOOSENESS = T(2.5);
  MovingBoxOf<T> m_around;
  T m_size = T(0); ///< of the largest
};

} // namespace

std::vector<std::size_t> first_points_of_parts(const Surface& surface) {
  return first_of_parts(surface, surface.points(), [](std::int32_t point) { return point; });
}

template <class T>
BoxSearch<T>::BoxSearch(const Surface& surface, const Threads& threads, FindInTree<T> find_in_tree)
    : m_surface(surface)
    , m_threads(threads)
    , m_find_in_tree(find_in_tree)
    , m_first_point(first_points_of_parts(surface))
    , m_first_edge(first_of_parts(surface, surface.edges(), [](const Surface::Edge& edge) { return edge[0]; }))
    , m_first_triangle(
          first_of_parts(surface, surface.triangles(), [](const Surface::Triangle& triangle) { return triangle[0]; }))
    , m_triangle_trees(static_cast<std::size_t>(surface.part_count()))
    , m_edge_trees(static_cast<std::size_t>(surface.part_count()))
    , m_partners(static_cast<std::size_t>(surface.part_count())) {}

template <class T> void BoxSearch<T>::update(const std::vector<AnyBox>& nodes, PairGroup group, double distance) {
  m_nodes = &nodes;
  m_distance = distance;
  put_boxes(m_surface.triangles(), nodes, m_threads, m_triangle_boxes);
  put_boxes(m_surface.edges(), nodes, m_threads, m_edge_boxes);
  m_threads.for_each(2 * m_triangle_trees.size(), 1, [&](std::size_t tree) {
    const std::size_t part = tree / 2;
    if (tree % 2 == 0)
      m_triangle_trees[part].update(m_triangle_boxes, m_first_triangle[part], m_first_triangle[part + 1]);
    else
      m_edge_trees[part].update(m_edge_boxes, m_first_edge[part], m_first_edge[part + 1]);
  });
  find_partners(group);
}

/// Parts whose boxes, grown by the distance, meet.
template <class T> void BoxSearch<T>::find_partners(PairGroup group) {
  const std::size_t parts = m_partners.size();
  std::vector<AnyBox> bounds(parts);
  for (std::size_t part = 0; part < parts; ++part) {
    for (std::size_t i = m_first_point[part]; i < m_first_point[part + 1]; ++i) {
      const AnyBox& box = (*m_nodes)[m_surface.points()[i]];
      if (i == m_first_point[part])
        bounds[part] = box;
      bounds[part].include(box);
    }
  }
  for (std::size_t a = 0; a < parts; ++a) {
    m_partners[a].clear();
    if (m_first_point[a] == m_first_point[a + 1])
      continue;
    AnyBox box = bounds[a];
    box.grow(m_distance);
    for (std::size_t b = 0; b < parts; ++b) {
      const bool wanted = (group == PairGroup::within_parts) == (a == b) &&
                          m_surface.meet(static_cast<int>(a), static_cast<int>(b)) &&
                          m_first_point[b] != m_first_point[b + 1];
      if (wanted && bounds[b].meets(box))
        m_partners[a].push_back(static_cast<int>(b));
    }
  }
}

/// Adds a pair for every box of the tree that the query meets: pair_of(hit, pair) says whether it is one. Nothing
/// branches on the answer, which cannot be foretold.
template <class T>
template <class PairOf>
void BoxSearch<T>::find(const TreeOf<AnyBox>& tree, const TreeQuery<T>& query, std::vector<CandidatePair>& out,
                        const PairOf& pair_of) const {
  if (tree.nodes().empty())
    return;
  std::array<TreeHit, 512> hits;
  TreeWalk walk(tree.nodes().front().is_leaf);
  while (!walk.is_over()) {
    const int count = m_find_in_tree(tree.nodes().data(), query, walk, hits.data(), static_cast<int>(hits.size()));
    std::size_t used = out.size();
    out.resize(used + static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i)
      used += static_cast<std::size_t>(pair_of(hits[static_cast<std::size_t>(i)], out[used]));
    out.resize(used);
  }
}

template <class T>
void BoxSearch<T>::add_triangles(std::int32_t begin, std::int32_t end, std::vector<CandidatePair>& out) const {
  const auto node_of = [&](std::int32_t point) { return m_surface.points()[static_cast<std::size_t>(point)]; };
  while (begin < end) {
    const int part = m_surface.part_of_node(node_of(begin));
    const std::int32_t first = begin;
    QueryGroup<T> group;
    for (; begin < end && m_surface.part_of_node(node_of(begin)) == part; ++begin) {
      AnyBox box = (*m_nodes)[static_cast<std::size_t>(node_of(begin))];
      box.grow(m_distance);
      if (!group.add(box, -1))
        break;
    }
    const auto pair_of = [&](const TreeHit& hit, CandidatePair& pair) {
      const std::int32_t node = node_of(first + hit.which);
      const Surface::Triangle& t = m_surface.triangles()[static_cast<std::size_t>(hit.index)];
      pair = {{node, t[0], t[1], t[2]}, first + hit.which, hit.index};
      return !has_node(t, node);
    };
    for (const int other : m_partners[static_cast<std::size_t>(part)])
      find(m_triangle_trees[static_cast<std::size_t>(other)], group.query, out, pair_of);
  }
}

/// Edges come in the order of their first nodes: those of a group are mostly fans.
template <class T>
void BoxSearch<T>::add_edges(std::int32_t begin, std::int32_t end, std::vector<CandidatePair>& out) const {
  const std::vector<Surface::Edge>& edges = m_surface.edges();
  const auto part_of = [&](std::int32_t edge) {
    return m_surface.part_of_node(edges[static_cast<std::size_t>(edge)][0]);
  };
  while (begin < end) {
    const int part = part_of(begin);
    const std::int32_t first = begin;
    QueryGroup<T> group;
    for (; begin < end && part_of(begin) == part; ++begin) {
      AnyBox box = m_edge_boxes[static_cast<std::size_t>(begin)];
      box.grow(m_distance);
      if (!group.add(box, begin))
        break;
    }
    const auto pair_of = [&](const TreeHit& hit, CandidatePair& pair) {
      const std::int32_t edge = first + hit.which;
      const Surface::Edge& e = edges[static_cast<std::size_t>(edge)];
      const Surface::Edge& f = edges[static_cast<std::size_t>(hit.index)];
      pair = {{e[0], e[1], f[0], f[1]}, edge, hit.index};
      return !share_node(e, f);
    };
    for (const int other : m_partners[static_cast<std::size_t>(part)]) {
      if (other >= part)
        find(m_edge_trees[static_cast<std::size_t>(other)], group.query, out, pair_of);
    }
  }
}

template <class T> std::size_t BoxSearch<T>::memory_bytes() const {
  return 2 * (m_triangle_boxes.capacity() + m_edge_boxes.capacity()) * sizeof(AnyBox);
}

template class BoxSearch<float>;
template class BoxSearch<double>;

} // namespace wry::contact
