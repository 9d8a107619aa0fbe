#pragma once

#include <cstdint>
#include <vector>

#include "sim/contact/candidate_pair.h"
#include "sim/contact/ccd.h"
#include "sim/contact/moving_box.h"
#include "sim/contact/search_kernels.h"
#include "sim/contact/surface.h"

namespace wry::contact {

/// Positions of nodes, and of the middles of parts, which are taken off: zero where they are not to be.
struct Placed {
  const Points& positions;
  Points middles; ///< parts x 3
};

/// How far each node has come, at either of two places: in single precision, since it serves the quick answer that most
/// pairs are as far apart as they were. What rounding does is on the safe side.
class Ways {
public:
  void measure(const Surface& surface, const SearchTable& kernels, const Placed& since, const Placed& first,
               const Placed& second);

  /// The pairs of [begin, end) that may have come nearer to each other, at one of the places, by what they were apart
  /// less `taken` [m].
  void find_moved(PairKind kind, const std::vector<CandidatePair>& pairs, std::size_t begin, std::size_t end,
                  double taken, std::vector<std::int32_t>& out) const;
  /// The same less what each pair has to be near to matter.
  void find_in_reach(PairKind kind, const std::vector<CandidatePair>& pairs, std::size_t begin, std::size_t end,
                     std::vector<std::int32_t>& out) const;

private:
  void find(PairKind kind, const std::vector<CandidatePair>& pairs, std::size_t begin, std::size_t end, float taken,
            std::vector<std::int32_t>& out) const;

  struct Way {
    Eigen::Array4f first, second;
  };
  std::vector<Way> m_ways; ///< per node
  int m_places = 0;
  float m_rounding = 0.0F;
  FindMoved m_find_moved[2] = {}; ///< by kind
};

/// Pairs as kernels read them.
PairRecords records_of(const CandidatePair* pairs, std::size_t count);

} // namespace wry::contact
