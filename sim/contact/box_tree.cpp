#include "sim/contact/box_tree.h"

#include <array>
#include <numeric>

namespace wry::contact {

namespace {

constexpr std::int32_t LANES = 4;
/// A tree is built anew when its boxes have become larger by this factor, against what they contain.
constexpr double MOST_LOOSENESS = 1.3;

} // namespace

template <class AnyBox>
void TreeOf<AnyBox>::build(const std::vector<AnyBox>& boxes, std::size_t begin, std::size_t end) {
  m_nodes.clear();
  m_members.resize(end - begin);
  std::iota(m_members.begin(), m_members.end(), static_cast<std::int32_t>(begin));
  if (m_members.empty())
    return;
  build_node(boxes, 0, static_cast<std::int32_t>(m_members.size()));
  refit(boxes);
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

template <class AnyBox> void TreeOf<AnyBox>::refit(const std::vector<AnyBox>& boxes) {
  for (std::size_t index = m_nodes.size(); index-- > 0;) {
    Node& node = m_nodes[index];
    for (std::int32_t lane = 0; lane < node.count; ++lane) {
      const std::int32_t child = node.child[lane];
      put(node.pack, lane, node.is_leaf ? boxes[child] : whole(m_nodes[child].pack));
    }
  }
}

/// Sizes of the nodes over those of what is in them: how much is visited in vain.
template <class AnyBox> double TreeOf<AnyBox>::looseness() const {
  double nodes = 0.0;
  double members = 0.0;
  for (const Node& node : m_nodes)
    (node.is_leaf ? members : nodes) += sizes(node.pack);
  return members > 0.0 ? nodes / members : 0.0;
}

/// Orders the members so that what lies low along the longest side comes first. Returns where the second half begins,
/// such that leaves are full.
template <class AnyBox>
std::int32_t TreeOf<AnyBox>::halve(const std::vector<AnyBox>& boxes, std::int32_t begin, std::int32_t end) {
  double low[3];
  double high[3];
  for (int i = 0; i < 3; ++i)
    low[i] = high[i] = boxes[m_members[begin]].low[i] + boxes[m_members[begin]].high[i];
  for (std::int32_t k = begin + 1; k < end; ++k) {
    const AnyBox& box = boxes[m_members[k]];
    for (int i = 0; i < 3; ++i) {
      const double twice_middle = box.low[i] + box.high[i];
      low[i] = std::min(low[i], twice_middle);
      high[i] = std::max(high[i], twice_middle);
    }
  }
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    axis = high[i] - low[i] > high[axis] - low[axis] ? i : axis;
  const std::int32_t half = ((end - begin) / 2 + LANES - 1) / LANES * LANES;
  const std::int32_t middle = begin + half;
  std::nth_element(m_members.begin() + begin, m_members.begin() + middle, m_members.begin() + end,
                   [&](std::int32_t a, std::int32_t b) {
                     const double x = boxes[a].low[axis] + boxes[a].high[axis];
                     const double y = boxes[b].low[axis] + boxes[b].high[axis];
                     return x != y ? x < y : a < b;
                   });
  return middle;
}

/// All but the boxes, which `refit` puts in.
template <class AnyBox>
std::int32_t TreeOf<AnyBox>::build_node(const std::vector<AnyBox>& boxes, std::int32_t begin, std::int32_t end) {
  const auto index = static_cast<std::int32_t>(m_nodes.size());
  clear(m_nodes.emplace_back().pack);
  if (end - begin <= LANES) {
    Node& node = m_nodes.back();
    node.is_leaf = true;
    node.count = end - begin;
    std::copy(m_members.begin() + begin, m_members.begin() + end, node.child);
    std::copy_n(node.child, node.count, node.last);
    return index;
  }
  std::array<std::int32_t, LANES + 1> bounds = {begin, 0, 0, 0, 0};
  std::int32_t parts = 0;
  const std::int32_t middle = halve(boxes, begin, end);
  for (const auto& [from, to] : {std::pair(begin, middle), std::pair(middle, end)}) {
    if (to - from > LANES)
      bounds[static_cast<std::size_t>(++parts)] = halve(boxes, from, to);
    bounds[static_cast<std::size_t>(++parts)] = to;
  }
  for (std::size_t part = 0; part < static_cast<std::size_t>(parts); ++part) {
    const std::int32_t child = build_node(boxes, bounds[part], bounds[part + 1]);
    const std::int32_t* below = m_nodes[child].last;
    const std::int32_t last = *std::max_element(below, below + m_nodes[child].count);
    Node& node = m_nodes[index];
    node.child[part] = child;
    node.last[part] = last;
    node.leaf_children |= static_cast<std::uint32_t>(m_nodes[child].is_leaf) << part;
    ++node.count;
  }
  return index;
}

template class TreeOf<Box>;
template class TreeOf<MovingBox>;
template class TreeOf<WideMovingBox>;

} // namespace wry::contact
