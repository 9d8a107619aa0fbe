#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "sim/base/types.h"
#include "sim/contact/box_pack.h"

namespace wry::contact {

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

  /// Calls visit(index) for every box that meets the query, in an order that depends on how the tree was built. Trees
  /// of moving boxes are asked by kernels (`FindInTree`).
  template <class Visit> void query(const AnyBox& box, const Visit& visit) const {
    if (m_nodes.empty())
      return;
    std::int32_t stack[64];
    int depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
      const Node& node = m_nodes[static_cast<std::size_t>(stack[--depth])];
      for (unsigned mask = meeting(node.pack, box); mask != 0; mask &= mask - 1) {
        const std::int32_t child = node.child[std::countr_zero(mask)];
        if (node.is_leaf)
          visit(child);
        else
          stack[depth++] = child;
      }
    }
  }

  using Node = TreeNode<typename PackOf<AnyBox>::Type>;
  const std::vector<Node>& nodes() const { return m_nodes; }

  std::size_t memory_bytes() const {
    return m_nodes.capacity() * sizeof(Node) + m_members.capacity() * sizeof(std::int32_t);
  }

private:
  std::int32_t build_node(const std::vector<AnyBox>& boxes, std::int32_t begin, std::int32_t end);
  std::int32_t halve(const std::vector<AnyBox>& boxes, std::int32_t begin, std::int32_t end);
  void refit(const std::vector<AnyBox>& boxes);
  double looseness() const;

  std::vector<Node> m_nodes;
  std::vector<std::int32_t> m_members; ///< as they are halved
  double m_built_looseness = 0.0;
};

using BoxTree = TreeOf<Box>;
extern template class TreeOf<Box>;
extern template class TreeOf<MovingBox>;
extern template class TreeOf<WideMovingBox>;

} // namespace wry::contact
