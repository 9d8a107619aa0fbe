#pragma once

#include <cstdint>
#include <vector>

#include "sim/base/parallel.h"
#include "sim/contact/box_tree.h"
#include "sim/contact/ccd.h"
#include "sim/contact/surface.h"

namespace wry::contact {

/// A pair of primitives that may come near each other: its nodes in the order of PairPoints.
struct CandidatePair {
  std::array<std::int32_t, 4> nodes;
  std::int32_t first = 0;  ///< point, or edge, by its place in the surface
  std::int32_t second = 0; ///< triangle, or edge
};

/// Finds all pairs that can come within a distance, and keeps them while every node stays within the room it was given.
///
/// Each node gets a box around two places, grown by a margin; a pair is a candidate if the boxes of its primitives,
/// grown by the distance, meet. So the lists hold for all positions, and all straight ways between positions, inside
/// the rooms: Newton's iterations share one search. Lists are the same on any number of threads; at most
/// `most_pairs` are kept.
class BroadPhase {
public:
  BroadPhase(const Surface& surface, const Threads& threads, std::size_t most_pairs)
      : m_surface(surface)
      , m_threads(threads)
      , m_most_pairs(most_pairs) {}

  /// Makes the lists hold for both sets of positions (nodes x 3) and between them. Does nothing when they do already.
  /// False when there are more than most_pairs: then the lists are empty and a shorter way must be asked for.
  bool cover(const Points& from, const Points& to, double distance, double margin);

  const std::vector<CandidatePair>& point_triangles() const { return m_point_triangles; }
  const std::vector<CandidatePair>& edge_edges() const { return m_edge_edges; }
  const std::vector<CandidatePair>& pairs(PairKind kind) const {
    return kind == PairKind::edge_edge ? m_edge_edges : m_point_triangles;
  }
  int searches() const { return m_searches; } ///< how often lists were made
  std::size_t memory_bytes() const;

private:
  bool holds(const Points& positions) const;
  bool search(double distance);
  template <class Find>
  bool collect(std::size_t count, std::vector<CandidatePair>& out, std::size_t room, const Find& find);

  const Surface& m_surface;
  const Threads& m_threads;
  std::size_t m_most_pairs;
  double m_distance = -1.0;
  bool m_valid = false;
  int m_searches = 0;
  std::vector<Box> m_rooms; ///< per node of the surface
  std::vector<Box> m_triangle_boxes, m_edge_boxes;
  BoxTree m_triangle_tree, m_edge_tree;
  std::vector<std::vector<CandidatePair>> m_chunks;
  std::vector<CandidatePair> m_point_triangles, m_edge_edges;
};

/// All pairs that can touch at all, by looking at each: what the search has to agree with, for tests.
std::vector<CandidatePair> all_pairs(const Surface& surface, PairKind kind);

} // namespace wry::contact
