#include "sim/contact/ways.h"

#include <cfloat>
#include <cstddef>

namespace wry::contact {

namespace {

/// Kernels count from one record to the next in words.
static_assert(sizeof(CandidatePair) == PAIR_RECORD * sizeof(std::int32_t));
static_assert(sizeof(CandidatePair::nodes) == 4 * sizeof(std::int32_t));

} // namespace

PairRecords records_of(const CandidatePair* pairs, std::size_t count) {
  return {pairs->nodes.data(), &pairs->apart, &pairs->reach, static_cast<int>(count)};
}

void Ways::measure(const Surface& surface, const SearchTable& kernels, const Placed& since, const Placed& first,
                   const Placed& second) {
  m_find_moved[static_cast<int>(PairKind::point_triangle)] = kernels.find_moved_triangles;
  m_find_moved[static_cast<int>(PairKind::edge_edge)] = kernels.find_moved_edges;
  m_ways.resize(static_cast<std::size_t>(surface.node_count()));
  m_places = &first.positions == &second.positions ? 1 : 2;
  const Points flown[2] = {first.middles - since.middles, second.middles - since.middles};
  Eigen::Array4f most = Eigen::Array4f::Zero();
  const auto way = [&](const Placed& now, const Points& off, std::int32_t node, int part) {
    const Eigen::Array3d exact = now.positions.row(node) - since.positions.row(node) - off.row(part);
    Eigen::Array4f rounded(static_cast<float>(exact[0]), static_cast<float>(exact[1]), static_cast<float>(exact[2]), 0);
    most = most.max(rounded.abs());
    return rounded;
  };
  for (const std::int32_t node : surface.points()) {
    const int part = surface.part_of_node(node);
    Way& ways = m_ways[static_cast<std::size_t>(node)];
    ways.first = way(first, flown[0], node, part);
    if (m_places == 2)
      ways.second = way(second, flown[1], node, part);
  }
  // Two roundings to single precision, a difference and a sum of three squares, each half a unit.
  m_rounding = 8.0F * FLT_EPSILON * most.maxCoeff();
}

void Ways::find_moved(PairKind kind, const std::vector<CandidatePair>& pairs, std::size_t begin, std::size_t end,
                      double taken, std::vector<std::int32_t>& out) const {
  find(kind, pairs, begin, end, static_cast<float>(taken) * (1.0F + FLT_EPSILON), out);
}

void Ways::find_in_reach(PairKind kind, const std::vector<CandidatePair>& pairs, std::size_t begin, std::size_t end,
                         std::vector<std::int32_t>& out) const {
  find(kind, pairs, begin, end, -1.0F, out);
}

void Ways::find(PairKind kind, const std::vector<CandidatePair>& pairs, std::size_t begin, std::size_t end, float taken,
                std::vector<std::int32_t>& out) const {
  out.resize(end - begin);
  int count = 0;
  if (end > begin) {
    const MovedQuestion question{m_ways.front().first.data(), m_places, m_rounding, taken};
    count = m_find_moved[static_cast<int>(kind)](question, records_of(&pairs[begin], end - begin), out.data());
  }
  out.resize(static_cast<std::size_t>(count));
  for (std::int32_t& index : out)
    index += static_cast<std::int32_t>(begin);
}

} // namespace wry::contact
