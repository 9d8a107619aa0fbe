#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "sim/base/parallel.h"
#include "sim/contact/box_search.h"
#include "sim/contact/candidate_pair.h"
#include "sim/contact/ccd.h"
#include "sim/contact/surface.h"
#include "sim/contact/ways.h"

namespace wry::contact {

/// How near the primitives of one part have to be to matter, at most the distance that is asked for [m].
using ReachFunction = std::function<double(PairKind, const std::array<std::int32_t, 4>&)>;

/// Finds all pairs that can come within a distance while nodes go straight ways.
///
/// All nodes are taken to be about as far along their ways, each within a small ball around its place there. Pairs of
/// one part are seen from its middle. What is asked for is found among the pairs of a longer list, while nodes go short
/// ways: each node gets a room there, and the list holds while every node stays within its own. Long ways leave all
/// rooms at once: for these, trees of boxes that move are searched. In these only the motion of boxes against each
/// other counts, so that a part which tumbles meets itself no more often than one at rest.
///
/// Newton's iterations share one search where they can. Lists are the same on any number of threads; at most
/// `most_pairs` are looked at of each group.
class BroadPhase {
public:
  /// `reach_within` may be empty: the distance, then.
  BroadPhase(const Surface& surface, const Threads& threads, std::size_t most_pairs, ReachFunction reach_within = {});

  /// Makes the pairs hold for both sets of positions (nodes x 3) and between them. Does nothing when they do already.
  /// False when more than most_pairs come near each other: then a group has no pairs, and a shorter way must be asked
  /// for.
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
  std::size_t pair_count() const;             ///< of all lists
  int searches() const { return m_searches; } ///< how often trees were searched
  std::size_t memory_bytes() const;

private:
  using PairLists = std::array<std::vector<CandidatePair>, 2>; ///< by kind
  struct Lists {
    bool needed = false; ///< some parts may meet so
    // What pairs are picked from.
    bool valid = false;
    double distance = -1.0;
    std::vector<Box> rooms; ///< per node of the surface, relative to `middles_of` its part
    Points measured_at;
    PairLists pairs;
    int served = 1 << 20; ///< how often pairs were picked from the last list
    int unserved = 0;     ///< how often they might have been, had there been a list
    // The pairs that are near.
    bool near_valid = false;
    bool near_is_picked = false; ///< from the list, which holds in its rooms only
    double near_distance = -1.0;
    double near_ball = 0.0;     ///< how far from places along the ways a node may be [m]
    Points near_from, near_way; ///< relative to the middles: the ways around which nodes may be
    Points near_measured_at;
    PairLists near;
  };
  const Lists& lists(PairGroup group) const { return m_lists[static_cast<std::size_t>(group)]; }
  using Find = std::function<void(std::int32_t begin, std::int32_t end, std::vector<CandidatePair>&)>;
  /// Measures the pairs from `begin` on, and leaves out those that are not wanted.
  using Finish = std::function<void(std::vector<CandidatePair>&, std::size_t begin)>;

  Points middles_of(const Points& positions, PairGroup group) const;
  bool hold(const std::vector<Box>& rooms, PairGroup group, const Points& from, const Points& to) const;
  bool hold(const std::vector<Box>& rooms, const Points& positions, const Points& middles) const;
  double longest_way(const Points& from, const Points& to, PairGroup group) const;
  bool is_near_valid_for(const Lists& lists, PairGroup group, const Points& positions) const;
  bool cover_group(PairGroup group, const Points& from, const Points& to, double distance, double margin);
  bool make_list(const Points& from, const Points& to, PairGroup group, double distance, double margin);
  void give_rooms(const Points& from, const Points& to, PairGroup group, double margin);
  bool search_rooms(PairGroup group, double distance);
  void set_ways(const Points& from, const Points& to, PairGroup group, double distance);
  void pick(const Points& from, const Points& to, PairGroup group);
  double put_moving_boxes(const Points& places, const Points& ways);
  bool search_moving(const Points& from, const Points& to, PairGroup group, double distance);
  template <class AnyBox>
  bool search(const BoxSearch<AnyBox>& boxes, const std::function<Finish(PairKind)>& finish, PairLists& out);
  void measure(PairKind kind, PairGroup group, const Points& at, double distance, double rounding,
               CandidatePair& pair) const;
  void measure_ways(PairGroup group, const Points& since, const Points& positions, Ways& out) const;
  void join_chunks(std::size_t count, std::vector<CandidatePair>& out);
  std::size_t collect(std::size_t count, std::size_t room, const Find& find, const Finish& finish,
                      std::vector<CandidatePair>& out);

  const Surface& m_surface;
  const Threads& m_threads;
  std::size_t m_most_pairs;
  ReachFunction m_reach_within;
  int m_searches = 0;
  std::array<Lists, 2> m_lists;           ///< by group
  std::vector<std::size_t> m_first_point; ///< per part, and one past the last
  BoxSearch<Box> m_room_search;
  BoxSearch<MovingBox> m_moving_search;
  std::vector<MovingBox> m_moving_boxes; ///< per node
  std::vector<std::vector<CandidatePair>> m_chunks;
  Ways m_from_ways, m_to_ways;
};

/// All pairs that can touch at all, by looking at each: what the search has to agree with, for tests.
std::vector<CandidatePair> all_pairs(const Surface& surface, PairKind kind);

} // namespace wry::contact
