#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "sim/base/types.h"
#include "sim/contact/box_pack.h"

namespace wry::contact {

/// An axis-aligned box [m].
struct Box {
  double low[3];
  double high[3];

  bool meets(const Box& other) const {
    return low[0] <= other.high[0] && other.low[0] <= high[0] && low[1] <= other.high[1] && other.low[1] <= high[1] &&
           low[2] <= other.high[2] && other.low[2] <= high[2];
  }
  void include(const Box& other) {
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], other.low[i]);
      high[i] = std::max(high[i], other.high[i]);
    }
  }
  void grow(double by) {
    for (int i = 0; i < 3; ++i) {
      low[i] -= by;
      high[i] += by;
    }
  }
};

/// A tree of boxes with four children to a node, halved twice at the median along the longest side; the same for the
/// same boxes. Storage is kept between builds.
template <class AnyBox> class TreeOf {
public:
  /// Of the boxes [begin, end); queries name them by their place in the whole list.
  void build(const std::vector<AnyBox>& boxes, std::size_t begin, std::size_t end);
  void build(const std::vector<AnyBox>& boxes) { build(boxes, 0, boxes.size()); }
  /// Of the boxes [begin, end) again, which have moved: keeps who is whose neighbour, for a small part of the time,
  /// while that still serves, else builds. What a query finds is the same, its order may not be.
  void update(const std::vector<AnyBox>& boxes, std::size_t begin, std::size_t end);

  /// Calls visit(index) for every box beyond `after` that meets the query, in an order that depends on how the tree was
  /// built.
  template <class Visit> void query(const AnyBox& box, const Visit& visit, std::int32_t after = -1) const {
    query(&box, 1, box, &after, [&](int, std::int32_t index) { visit(index); });
  }

  /// The same for several boxes that are near each other, in less time: visit(which, index). Which boxes count for each
  /// of them begins beyond its own `after`.
  template <class Visit>
  void query(const AnyBox* boxes, int count, const AnyBox& around, const std::int32_t* after,
             const Visit& visit) const {
    if (m_nodes.empty())
      return;
    const std::int32_t least = *std::min_element(after, after + count);
    std::int32_t stack[64];
    int depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
      const Node& node = m_nodes[stack[--depth]];
      if (!node.is_leaf) {
        for_each_lane(node.pack.meeting(around), [&](std::size_t lane) {
          if (node.last[lane] > least)
            stack[depth++] = node.child[lane];
        });
        continue;
      }
      for (int which = 0; which < count; ++which) {
        for_each_lane(node.pack.meeting(boxes[which]), [&](std::size_t lane) {
          if (node.child[lane] > after[which])
            visit(which, node.child[lane]);
        });
      }
    }
  }

  std::size_t memory_bytes() const {
    return m_nodes.capacity() * sizeof(Node) + m_members.capacity() * sizeof(std::int32_t);
  }

private:
  struct Node {
    BoxPack<AnyBox> pack;
    std::array<std::int32_t, 4> child; ///< nodes, which come after their parents, or boxes
    std::array<std::int32_t, 4> last;  ///< the greatest box below
    std::int32_t count = 0;
    bool is_leaf = false;
  };
  template <class Lane> static void for_each_lane(unsigned mask, const Lane& lane) {
    for (; mask != 0; mask &= mask - 1)
      lane(static_cast<std::size_t>(std::countr_zero(mask)));
  }
  std::int32_t build_node(const std::vector<AnyBox>& boxes, std::int32_t begin, std::int32_t end);
  std::int32_t halve(const std::vector<AnyBox>& boxes, std::int32_t begin, std::int32_t end);
  void refit(const std::vector<AnyBox>& boxes);
  double looseness() const;

  std::vector<Node> m_nodes;
  std::vector<std::int32_t> m_members; ///< as they are halved
  double m_built_looseness = 0.0;
};

using BoxTree = TreeOf<Box>;
using MovingTree = TreeOf<MovingBox>;
extern template class TreeOf<Box>;
extern template class TreeOf<MovingBox>;
extern template class TreeOf<WideMovingBox>;

} // namespace wry::contact
