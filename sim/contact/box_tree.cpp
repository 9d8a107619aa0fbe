#include "sim/contact/box_tree.h"

#include <numeric>

namespace wry::contact {

namespace {

constexpr std::int32_t LEAF_SIZE = 4;
/// A tree is built anew when its boxes have become larger by this factor, against what they contain.
constexpr double MOST_LOOSENESS = 1.3;

template <class AnyBox> double size_of(const AnyBox& box) {
  return (box.high[0] - box.low[0]) + (box.high[1] - box.low[1]) + (box.high[2] - box.low[2]);
}

} // namespace

template <class AnyBox>
void TreeOf<AnyBox>::build(const std::vector<AnyBox>& boxes, std::size_t begin, std::size_t end) {
  m_nodes.clear();
  m_members.resize(end - begin);
  std::iota(m_members.begin(), m_members.end(), static_cast<std::int32_t>(begin));
  m_leaf_boxes.resize(m_members.size());
  if (m_members.empty())
    return;
  build_node(boxes, 0, static_cast<std::int32_t>(m_members.size()));
  for (std::size_t i = 0; i < m_members.size(); ++i)
    m_leaf_boxes[i] = boxes[m_members[i]];
  m_built_looseness = looseness();
}

template <class AnyBox>
void TreeOf<AnyBox>::update(const std::vector<AnyBox>& boxes, std::size_t begin, std::size_t end) {
  const bool same = m_members.size() == end - begin && !m_members.empty();
  if (same)
    refit(boxes);
  if (!same || looseness() > MOST_LOOSENESS * m_built_looseness)
    build(boxes, begin, end);
}

/// Children come after their parents.
template <class AnyBox> void TreeOf<AnyBox>::refit(const std::vector<AnyBox>& boxes) {
  for (std::size_t i = 0; i < m_members.size(); ++i)
    m_leaf_boxes[i] = boxes[m_members[i]];
  for (std::size_t index = m_nodes.size(); index-- > 0;) {
    Node& node = m_nodes[index];
    if (node.right != 0) {
      node.box = m_nodes[index + 1].box;
      node.box.include(m_nodes[static_cast<std::size_t>(node.right)].box);
      continue;
    }
    node.box = m_leaf_boxes[static_cast<std::size_t>(node.begin)];
    for (std::int32_t i = node.begin + 1; i < node.end; ++i)
      node.box.include(m_leaf_boxes[static_cast<std::size_t>(i)]);
  }
}

/// Sizes of the nodes over those of what is in them: how much is visited in vain.
template <class AnyBox> double TreeOf<AnyBox>::looseness() const {
  double nodes = 0.0;
  double members = 0.0;
  for (const Node& node : m_nodes)
    nodes += size_of(node.box);
  for (const AnyBox& box : m_leaf_boxes)
    members += size_of(box);
  return members > 0.0 ? nodes / members : 0.0;
}

template <class AnyBox>
std::int32_t TreeOf<AnyBox>::build_node(const std::vector<AnyBox>& boxes, std::int32_t begin, std::int32_t end) {
  AnyBox box = boxes[m_members[begin]];
  double low[3];
  double high[3];
  for (int i = 0; i < 3; ++i)
    low[i] = high[i] = box.low[i] + box.high[i];
  std::int32_t last = 0;
  for (std::int32_t k = begin; k < end; ++k) {
    last = std::max(last, m_members[k]);
    const AnyBox& other = boxes[m_members[k]];
    box.include(other);
    for (int i = 0; i < 3; ++i) {
      const double twice_middle = other.low[i] + other.high[i];
      low[i] = std::min(low[i], twice_middle);
      high[i] = std::max(high[i], twice_middle);
    }
  }
  const auto index = static_cast<std::int32_t>(m_nodes.size());
  m_nodes.push_back({box, begin, end, 0, last});
  if (end - begin <= LEAF_SIZE)
    return index;
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    axis = high[i] - low[i] > high[axis] - low[axis] ? i : axis;
  const std::int32_t middle = begin + (end - begin) / 2;
  std::nth_element(m_members.begin() + begin, m_members.begin() + middle, m_members.begin() + end,
                   [&](std::int32_t a, std::int32_t b) {
                     const double x = boxes[a].low[axis] + boxes[a].high[axis];
                     const double y = boxes[b].low[axis] + boxes[b].high[axis];
                     return x != y ? x < y : a < b;
                   });
  build_node(boxes, begin, middle);
  m_nodes[index].right = build_node(boxes, middle, end);
  return index;
}

template class TreeOf<Box>;
template class TreeOf<MovingBox>;

} // namespace wry::contact
