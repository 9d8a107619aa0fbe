#include "sim/contact/safe_step.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/contact/distance.h"
#include "sim/contact/pair_boxes.h"

namespace wry::contact {

namespace {

constexpr std::size_t GRAIN = 1024;

/// Collects pairs until a batch is full, then asks.
class Asker {
public:
  Asker(PairKind kind, const CcdTable& table)
      : m_kind(kind)
      , m_table(table) {}

  void add(const PairPoints& from, const PairPoints& to, double separation, const std::array<std::int32_t, 4>& nodes) {
    for (int k = 0; k < 4; ++k) {
      for (int i = 0; i < 3; ++i) {
        m_batch.start[k][i][m_count] = from(k, i);
        m_batch.end[k][i][m_count] = to(k, i);
      }
    }
    m_batch.separation[m_count] = separation;
    m_nodes[static_cast<std::size_t>(m_count)] = nodes;
    if (++m_count == CCD_LANES)
      ask();
  }

  SafeStep finish() {
    if (m_count > 0)
      ask();
    return m_best;
  }

private:
  void ask() {
    double safe[CCD_LANES];
    m_batch.ceiling = m_best.fraction;
    find_safe_times(m_table, m_kind, m_batch, m_count, safe);
    for (int lane = 0; lane < m_count; ++lane) {
      if (safe[lane] < m_best.fraction)
        m_best = {safe[lane], m_kind, m_nodes[static_cast<std::size_t>(lane)]};
    }
    m_count = 0;
  }

  PairKind m_kind;
  const CcdTable& m_table;
  CcdBatch m_batch;
  std::array<std::array<std::int32_t, 4>, CCD_LANES> m_nodes{};
  int m_count = 0;
  SafeStep m_best;
};

/// Whether a pair, seen from its first point, stays apart along some axis all the way with more than `keep` between;
/// one side has `first` points.
bool apart_all_the_way(const PairPoints& from, const PairPoints& to, int first, double keep) {
  const Eigen::RowVector3d way = to.row(0) - from.row(0);
  for (int i = 0; i < 3; ++i) {
    double low[2] = {1e300, 1e300};
    double high[2] = {-1e300, -1e300};
    for (int k = 0; k < 4; ++k) {
      const int side = k < first ? 0 : 1;
      const double end = to(k, i) - way[i];
      low[side] = std::min({low[side], from(k, i), end});
      high[side] = std::max({high[side], from(k, i), end});
    }
    if (std::max(low[0] - high[1], low[1] - high[0]) > keep)
      return true;
  }
  return false;
}

/// How much nearer a pair can come at most: the largest difference of the ways of its points.
double most_approach(const PairPoints& ways, int first) {
  double most = 0.0;
  for (int a = 0; a < first; ++a) {
    for (int b = first; b < 4; ++b)
      most = std::max(most, (ways.row(a) - ways.row(b)).squaredNorm());
  }
  return std::sqrt(most);
}

/// A motion, and the ways to its ends from where the candidates' distances were measured.
struct Motion {
  const Points& from;
  const Points& to;
  Ways since_measured;
};

SafeStep ask_range(const std::vector<CandidatePair>& pairs, PairKind kind, std::size_t begin, std::size_t end,
                   const Motion& motion, const KeptDistance& keep, const CcdTable& table) {
  Asker asker(kind, table);
  const int first = kind == PairKind::edge_edge ? 2 : 1;
  const double most_kept = keep.most_thickness + std::max(keep.share * keep.reach, keep.least);
  // Most pairs move along with each other, and are near where they were measured.
  std::vector<std::int32_t> moved;
  motion.since_measured.find_moved(kind, pairs, begin, end, most_kept, moved);
  for (const std::int32_t index : moved) {
    const CandidatePair& pair = pairs[static_cast<std::size_t>(index)];
    const PairPoints start = gather(motion.from, pair.nodes);
    const PairPoints stop = gather(motion.to, pair.nodes);
    // `least` once more for what rounding the differences does.
    if (apart_all_the_way(start, stop, first, most_kept + keep.least))
      continue;
    const double distance = std::sqrt(squared_distance(kind, start));
    const double thickness = keep.thickness ? keep.thickness(kind, pair.nodes) : 0.0;
    const double kept = thickness + std::max(keep.share * std::min(keep.reach, distance - thickness), keep.least);
    // Half of a distance: it is not a proven bound itself.
    if (0.5 * distance - most_approach(stop - start, first) <= kept)
      asker.add(start, stop, kept, pair.nodes);
  }
  return asker.finish();
}

} // namespace

SafeStep find_safe_step(const BroadPhase& candidates, const Points& from, const Points& to, const KeptDistance& keep,
                        const CcdTable& table, const Threads& threads) {
  SafeStep best;
  for (const PairGroup group : PAIR_GROUPS) {
    if (candidates.pairs(group, PairKind::point_triangle).empty() &&
        candidates.pairs(group, PairKind::edge_edge).empty())
      continue;
    Motion motion{from, to, {}};
    candidates.measure_ways(group, from, to, motion.since_measured);
    for (const PairKind kind : {PairKind::point_triangle, PairKind::edge_edge}) {
      const std::vector<CandidatePair>& pairs = candidates.pairs(group, kind);
      std::vector<SafeStep> chunks((pairs.size() + GRAIN - 1) / GRAIN);
      threads.for_chunks(pairs.size(), GRAIN, [&](std::size_t begin, std::size_t end) {
        chunks[begin / GRAIN] = ask_range(pairs, kind, begin, end, motion, keep, table);
      });
      for (const SafeStep& chunk : chunks) {
        if (chunk.fraction < best.fraction)
          best = chunk;
      }
    }
  }
  return best;
}

} // namespace wry::contact
