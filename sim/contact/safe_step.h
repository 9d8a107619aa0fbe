#pragma once

#include <array>

#include "sim/contact/broad_phase.h"

namespace wry::contact {

/// How far a motion may go before a pair comes too near.
struct SafeStep {
  double fraction = 1.0;
  PairKind kind = PairKind::point_triangle;             ///< of the pair that limits it
  std::array<std::int32_t, 4> nodes = {-1, -1, -1, -1}; ///< its nodes; -1: nothing does
};

/// The largest fraction of the straight way `from` -> `to` that is proven to leave every candidate pair apart, with at
/// least the share `keep` of the distance it has at the start. Same bits on any number of threads. The candidates must
/// hold for both positions.
SafeStep find_safe_step(const BroadPhase& candidates, const Points& from, const Points& to, double keep,
                        const CcdTable& table, const Threads& threads);

} // namespace wry::contact
