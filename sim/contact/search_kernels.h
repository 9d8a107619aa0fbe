#pragma once

#include <cstdint>

namespace wry::contact {

/// Four moving boxes at most [m], by axis, then box. Boxes that were never put meet none. A box's low and high are
/// around all places at time 0, the other two around all ways.
template <class T> struct alignas(4 * sizeof(T)) MovingBoxes {
  T low[3][4], high[3][4], way_low[3][4], way_high[3][4];
};

/// A node of a tree: its children are nodes too, or, of a leaf, boxes of the list that the tree is of.
template <class Pack> struct TreeNode {
  Pack pack;
  std::int32_t child[4] = {}; ///< nodes, which come after their parents, or boxes
  std::int32_t last[4] = {};  ///< the greatest box below
  std::int32_t count = 0;
  std::uint32_t leaf_children = 0; ///< a bit per child that is a leaf
  bool is_leaf = false;
};

/// Boxes that are near each other, each of which asks for the boxes of a tree beyond its own `after`.
inline constexpr int MOST_ASKERS = 8;
template <class T> struct TreeQuery {
  MovingBoxes<T> boxes[MOST_ASKERS / 4];
  T low[3], high[3], way_low[3], way_high[3]; ///< around all
  std::int32_t after[MOST_ASKERS] = {};
  int count = 0;
};

/// Nodes that are still to be looked at: leaves by themselves, many at a time, so that what comes next is seldom
/// guessed wrong.
struct TreeWalk {
  std::int32_t stack[64];
  std::int32_t leaves[128];
  int depth = 0;
  int leaf_count = 0;

  explicit TreeWalk(bool root_is_leaf) {
    stack[0] = leaves[0] = 0;
    (root_is_leaf ? leaf_count : depth) = 1;
  }
  bool is_over() const { return depth == 0 && leaf_count == 0; }
};

struct TreeHit {
  std::int32_t which; ///< of the boxes that ask
  std::int32_t index; ///< of the boxes of the tree
};
/// So many hits more must fit for a walk to go on.
inline constexpr int HITS_OF_LEAF = 4 * MOST_ASKERS;

/// Finds the boxes that may meet those of the query at some time, in an order that depends on how the tree was built.
/// Goes on where the walk is, until no node is left or there is no room for the hits of one more leaf. Returns how many
/// hits were written.
template <class T>
using FindInTree = int (*)(const TreeNode<MovingBoxes<T>>* nodes, const TreeQuery<T>& query, TreeWalk& walk,
                           TreeHit* hits, int room);

/// Candidate pairs for a kernel: each record has four nodes and the numbers of CandidatePair, `PAIR_RECORD` 4-byte
/// words after the one before.
inline constexpr int PAIR_RECORD = 8;
struct PairRecords {
  const std::int32_t* nodes;
  const float* apart;
  const float* reach;
  int count;
};

/// What makes a pair of no interest: not within `distance` at any time of its way. Points are given by eight numbers
/// each: x y z of the place, one of no meaning, and the same of the way.
template <class T> struct NearQuestion {
  const T* points;
  T distance; ///< rounded up [m]
  T enough;   ///< pairs as far from each other at the start need no closer look [m]
  T rounding; ///< what it may take off a gap [m]
};
/// A pair that remains.
template <class T> struct NearAnswer {
  std::int32_t index;
  T apart;    ///< at the start at least, as far as a quick look tells [m]
  T approach; ///< how much nearer it comes at most [m]
};

/// Leaves out the pairs that are farther apart than asked for all the way, as the direction between the middles of the
/// primitives tells, and those that are enough apart and come near each other by less. Returns how many remain;
/// `answers` has room for one more than there are pairs.
template <class T>
using FindNear = int (*)(const NearQuestion<T>& question, const PairRecords& pairs, NearAnswer<T>* answers);

/// The pairs whose points have come nearer to each other by as much as they were apart, less `taken` or, if there is
/// none, the pair's reach: at either of up to two places. `ways` are eight numbers to a point, four to either place.
struct MovedQuestion {
  const float* ways;
  int places;
  float rounding; ///< of a way [m]
  float taken;    ///< rounded up [m]; below zero: each pair's reach
};
/// Writes the numbers of these pairs, ascending; returns how many. `out` has room for all.
using FindMoved = int (*)(const MovedQuestion& question, const PairRecords& pairs, std::int32_t* out);

/// For one instruction set.
template <class T> struct SearchKernels {
  FindInTree<T> find_in_tree;
  FindNear<T> find_near_triangles, find_near_edges;
};
struct SearchTable {
  SearchKernels<float> single;
  SearchKernels<double> wide;
  FindMoved find_moved_triangles, find_moved_edges;
};

namespace sse4 {
SearchTable search_table();
}
namespace avx2 {
SearchTable search_table();
}
namespace avx512 {
SearchTable search_table();
}

} // namespace wry::contact
