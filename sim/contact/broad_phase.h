#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "sim/base/isa.h"
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
/// All nodes are taken to be about as far along their ways, each within a ball around its place there. Pairs of one
/// part are seen from its middle. Trees of boxes that move are searched, in which only the motion of boxes against each
/// other counts: a part that tumbles meets itself no more often than one at rest.
///
/// What is asked for, with small balls, is picked from a longer list with larger ones, whose ways go on for some steps
/// where they are short. It holds while all nodes stay within theirs. Long ways are searched for themselves.
///
/// Newton's iterations share one search where they can. Lists are the same on any number of threads; at most
/// `most_pairs` are looked at of each group.
class BroadPhase {
public:
  /// `reach_within` may be empty: the distance, then.
  BroadPhase(const Surface& surface, const Threads& threads, std::size_t most_pairs, ReachFunction reach_within = {},
             Isa isa = native_isa());

  /// Makes the pairs hold for both sets of positions (nodes x 3) and between them. Does nothing when they do already.
  /// False when more than most_pairs come near each other: then a group has no pairs, and a shorter way must be asked
  /// for.
  bool cover(const Points& from, const Points& to, double distance, double margin);

  /// Where nodes go from here on, as far as one knows: lists are made along these ways.
  void expect_ways(Points ways) { m_expected_ways = std::move(ways); }

  /// How far the nodes go at most, by coordinate, beside what the middle of their part goes [m].
  double longest_way_within(const Points& from, const Points& to) const;

  /// In the order of first, then second.
  const std::vector<CandidatePair>& pairs(PairGroup group, PairKind kind) const {
    return lists(group).near.pairs[static_cast<std::size_t>(kind)];
  }
  /// How far the nodes have come at two places since the pairs' `apart` was measured.
  void measure_ways(PairGroup group, const Points& first, const Points& second, Ways& out) const;
  std::size_t pair_count() const;             ///< of all lists
  int searches() const { return m_searches; } ///< how often trees were searched
  std::size_t memory_bytes() const;

private:
  using PairLists = std::array<std::vector<CandidatePair>, 2>; ///< by kind
  /// The pairs that can come within `distance` while all nodes are in balls around places equally far along their ways.
  struct PairSet {
    bool valid = false;
    double distance = -1.0;
    double ball = 0.0; ///< radius [m]
    Points from, way;  ///< relative to the middles
    Points measured_at;
    PairLists pairs;
    double spent() const { return distance + 2.0 * ball; } ///< how far apart two places must be for a pair not to count
  };
  struct Lists {
    bool needed = false; ///< some parts may meet so
    PairSet list;        ///< what the near ones are picked from
    PairSet near;
    bool near_is_picked = false; ///< and holds only where the list does
    int served = 1 << 20;        ///< how often pairs were picked from the last list
    int unserved = 0;            ///< how often they might have been, had there been a list
  };
  template <class Scalar> struct Boxes {
    SearchKernels<Scalar> kernels;
    BoxSearch<Scalar> trees;
    std::vector<MovingBoxOf<Scalar>> nodes;  ///< of the surface
    std::vector<MovingPoint<Scalar>> points; ///< the same
    Boxes(const Surface& surface, const Threads& threads, const SearchKernels<Scalar>& of_isa)
        : kernels(of_isa)
        , trees(surface, threads, of_isa.find_in_tree) {}
    double place(const PairSet& set, const Surface& surface);
  };
  const Lists& lists(PairGroup group) const { return m_lists[static_cast<std::size_t>(group)]; }
  using Find = std::function<void(std::int32_t begin, std::int32_t end, std::vector<CandidatePair>&)>;
  /// Measures the pairs from `begin` on, and leaves out those that are not wanted.
  using Finish = std::function<void(std::vector<CandidatePair>&, std::size_t begin)>;

  Placed seen(const Points& positions, PairGroup group) const;
  double longest_way(const Placed& from, const Placed& to) const;
  bool holds(const PairSet& set, const Placed& at) const;
  bool holds(const PairSet& set, const Placed& from, const Placed& to) const;
  bool cover_group(PairGroup group, const Placed& from, const Placed& to, double distance, double margin);
  void set_ways(PairSet& set, const Placed& from, const Placed& to, double distance) const;
  void pick(PairGroup group, const Placed& from, const Placed& to);
  bool make_list(PairGroup group, const Placed& from, const Placed& to, double distance, double margin);
  bool search_near(PairGroup group, const Placed& from, const Placed& to, double distance);
  bool search(PairSet& set, PairGroup group);
  template <class Scalar> bool search(Boxes<Scalar>& boxes, PairSet& set, PairGroup group);
  void measure(PairKind kind, PairGroup group, const PairSet& set, double known, CandidatePair& pair) const;
  void join_chunks(std::size_t count, std::vector<CandidatePair>& out);
  std::size_t collect(std::size_t count, std::size_t room, const Find& find, const Finish& finish,
                      std::vector<CandidatePair>& out);

  const Surface& m_surface;
  const Threads& m_threads;
  std::size_t m_most_pairs;
  ReachFunction m_reach_within;
  SearchTable m_kernels;
  int m_searches = 0;
  Points m_expected_ways;                 ///< without rows before one knows
  std::array<Lists, 2> m_lists;           ///< by group
  std::vector<std::size_t> m_first_point; ///< per part, and one past the last
  Boxes<float> m_boxes;
  std::unique_ptr<Boxes<double>> m_wide_boxes; ///< once single precision has not been enough
  std::vector<std::vector<CandidatePair>> m_chunks;
  std::vector<std::vector<std::int32_t>> m_moved; ///< by chunk
  Ways m_ways;
};

} // namespace wry::contact
