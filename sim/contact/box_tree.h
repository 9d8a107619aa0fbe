#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "sim/base/types.h"
#include "sim/contact/moving_box.h"

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

/// A binary tree of boxes, halved at the median along the longest side; the same for the same boxes. Storage is kept
/// between builds.
template <class AnyBox> class TreeOf {
public:
  /// Of the boxes [begin, end); queries name them by their place in the whole list.
  void build(const std::vector<AnyBox>& boxes, std::size_t begin, std::size_t end);
  void build(const std::vector<AnyBox>& boxes) { build(boxes, 0, boxes.size()); }
  /// Of the boxes [begin, end) again, which have moved: keeps who is whose neighbour, for a small part of the time,
  /// while that still serves, else builds. What a query finds is the same, its order may not be.
  void update(const std::vector<AnyBox>& boxes, std::size_t begin, std::size_t end);

  /// Calls visit(index, box) for every box beyond `after` that meets the query, in an order that depends on how the
  /// tree was built.
  template <class Visit> void query(const AnyBox& box, const Visit& visit, std::int32_t after = -1) const {
    if (m_nodes.empty())
      return;
    std::int32_t stack[64];
    int depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
      const std::int32_t index = stack[--depth];
      const Node& node = m_nodes[index];
      if (node.last <= after || !node.box.meets(box))
        continue;
      if (node.right != 0) {
        stack[depth++] = node.right;
        stack[depth++] = index + 1;
        continue;
      }
      for (std::int32_t i = node.begin; i < node.end; ++i) {
        if (m_members[i] > after && m_leaf_boxes[i].meets(box))
          visit(m_members[i], m_leaf_boxes[i]);
      }
    }
  }

  /// The same for several boxes that are near each other, in less time: visit(which, index). Which boxes count for each
  /// of them begins beyond its own `after`.
  template <class Visit>
  void query(const AnyBox* boxes, int count, const AnyBox& around, const std::int32_t* after,
             const Visit& visit) const {
    std::int32_t least = after[0];
    for (int which = 1; which < count; ++which)
      least = std::min(least, after[which]);
    query(
        around,
        [&](std::int32_t index, const AnyBox& box) {
          for (int which = 0; which < count; ++which) {
            if (index > after[which] && boxes[which].meets(box))
              visit(which, index);
          }
        },
        least);
  }

private:
  struct Node {
    AnyBox box;
    std::int32_t begin, end;
    std::int32_t right; ///< the left child follows its parent; 0: a leaf
    std::int32_t last;  ///< the greatest member
  };
  std::int32_t build_node(const std::vector<AnyBox>& boxes, std::int32_t begin, std::int32_t end);
  void refit(const std::vector<AnyBox>& boxes);
  double looseness() const;

  std::vector<Node> m_nodes;
  std::vector<std::int32_t> m_members;
  std::vector<AnyBox> m_leaf_boxes; ///< in the order of the members
  double m_built_looseness = 0.0;
};

using BoxTree = TreeOf<Box>;
using MovingTree = TreeOf<MovingBox>;
extern template class TreeOf<Box>;
extern template class TreeOf<MovingBox>;

} // namespace wry::contact
