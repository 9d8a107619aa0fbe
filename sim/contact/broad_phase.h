#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "sim/base/parallel.h"
#include "sim/contact/box_tree.h"
#include "sim/contact/ccd.h"
#include "sim/contact/surface.h"
#include "sim/contact/ways.h"

namespace wry::contact {

/// A pair of primitives that may come near each other: its nodes in the order of PairPoints.
struct CandidatePair {
  std::array<std::int32_t, 4> nodes;
  std::int32_t first = 0;  ///< point, or edge, by its place in the surface
  std::int32_t second = 0; ///< triangle, or edge
  float apart = 0.0F; ///< what their distance was at least when the list was made, proven by a separating plane [m]
  float reach = 0.0F; ///< how near they have to be to matter, rounded up [m]
};

/// Whether pairs are of two parts or of one.
enum class PairGroup { between_parts, within_parts };
inline constexpr std::array PAIR_GROUPS = {PairGroup::between_parts, PairGroup::within_parts};

/// How near the primitives of one part have to be to matter, at most the distance that is asked for [m].
using ReachFunction = std::function<double(PairKind, const std::array<std::int32_t, 4>&)>;

/// Finds all pairs that can come within a distance, and keeps them while every node stays within the room it was given.
///
/// Each node gets a box around two places, grown by a margin; a pair is a candidate if the boxes of its primitives,
/// grown by the distance, meet. So the lists hold for all positions, and all straight ways between positions, inside
/// the rooms: Newton's iterations share one search. Rooms for pairs within a part move along with the middle of the
/// part, so that a body which flies keeps its list. Of these lists, those pairs are picked out that can come within
/// the distance while all nodes are about as far along their ways. Lists are the same on any number of threads; at most
/// `most_pairs` are kept of each group.
class BroadPhase {
public:
  /// `reach_within` may be empty: the distance, then.
  BroadPhase(const Surface& surface, const Threads& threads, std::size_t most_pairs, ReachFunction reach_within = {});

  /// Makes the lists hold for both sets of positions (nodes x 3) and between them. Does nothing when they do already.
  /// False when there are more than most_pairs: then a group's lists are empty and a shorter way must be asked for.
  bool cover(const Points& from, const Points& to, double distance, double margin);

  /// How far the nodes go at most, by coordinate, beside what the middle of their part goes [m].
  double longest_way_within(const Points& from, const Points& to) const {
    return longest_way(from, to, PairGroup::within_parts);
  }

  /// In the order of first, then second.
  const std::vector<CandidatePair>& pairs(PairGroup group, PairKind kind) const {
    return lists(group).near[static_cast<std::size_t>(kind)];
  }
  /// How far the nodes have come since the pairs' `apart` was measured.
  void measure_ways(PairGroup group, const Points& positions, Ways& out) const;
  std::size_t pair_count() const;             ///< of the lists from which they are picked
  int searches() const { return m_searches; } ///< how often lists were made
  std::size_t memory_bytes() const;

private:
  struct Lists {
    double distance = -1.0;
    bool needed = false; ///< some parts may meet so
    bool valid = false;
    double longest_way = 0.0; ///< of a node, for which the rooms were made
    std::vector<Box> rooms;   ///< per node of the surface, relative to `middles_of` its part
    Points measured_at;
    std::array<std::vector<CandidatePair>, 2> pairs; ///< by kind
    bool picked = false;
    Points picked_from, picked_way;                 ///< relative to the middles: the ways around which nodes may be
    std::array<std::vector<CandidatePair>, 2> near; ///< of the pairs
  };
  const Lists& lists(PairGroup group) const { return m_lists[static_cast<std::size_t>(group)]; }

  Points middles_of(const Points& positions, PairGroup group) const;
  bool hold(const std::vector<Box>& rooms, PairGroup group, const Points& from, const Points& to) const;
  bool hold(const std::vector<Box>& rooms, const Points& positions, const Points& middles) const;
  double longest_way(const Points& from, const Points& to, PairGroup group) const;
  void give_rooms(const Points& from, const Points& to, PairGroup group, double margin);
  void pick(const Points& from, const Points& to, PairGroup group);
  bool is_picked_for(const Lists& lists, const Points& positions, const Points& middles) const;
  void build_trees(const std::vector<Box>& rooms);
  void find_partners(PairGroup group, double distance);
  bool search(PairGroup group, double distance);
  void measure(PairKind kind, bool within, const Lists& lists, CandidatePair& pair) const;
  void join_chunks(std::size_t count, std::vector<CandidatePair>& out);
  template <class Find>
  bool collect(std::size_t count, Lists& lists, PairKind kind, std::size_t room, const Find& find);

  const Surface& m_surface;
  const Threads& m_threads;
  std::size_t m_most_pairs;
  ReachFunction m_reach_within;
  int m_searches = 0;
  std::array<Lists, 2> m_lists;                                           ///< by group
  std::vector<std::size_t> m_first_point, m_first_edge, m_first_triangle; ///< per part, and one past the last
  std::vector<Box> m_triangle_boxes, m_edge_boxes;
  std::vector<BoxTree> m_triangle_trees, m_edge_trees; ///< per part
  std::vector<std::vector<int>> m_partners;            ///< per part: those it can meet now
  std::vector<std::vector<CandidatePair>> m_chunks;
  Ways m_from_ways, m_to_ways;
};

/// All pairs that can touch at all, by looking at each: what the search has to agree with, for tests.
std::vector<CandidatePair> all_pairs(const Surface& surface, PairKind kind);

} // namespace wry::contact
