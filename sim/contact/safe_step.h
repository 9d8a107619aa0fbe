#pragma once

#include <array>
#include <functional>

#include "sim/contact/broad_phase.h"

namespace wry::contact {

/// How far a motion may go before a pair comes too near.
struct SafeStep {
  double fraction = 1.0;
  PairKind kind = PairKind::point_triangle;             ///< of the pair that limits it
  std::array<std::int32_t, 4> nodes = {-1, -1, -1, -1}; ///< its nodes; -1: nothing does
};

/// What must be left of the distance of a pair.
struct KeptDistance {
  double share = 0.1; ///< of the gap it has at the start, or of `reach` if that is less
  double reach = 0.0; ///< pairs whose gap stays larger than this do not limit a step [m]
  double least = 0.0; ///< [m]; covers what rounding of the positions does afterwards
  /// How much of a pair's distance is thickness, which is no gap [m]; at most `most_thickness`. Empty: none is.
  std::function<double(PairKind, const std::array<std::int32_t, 4>&)> thickness = {};
  double most_thickness = 0.0;
};

/// The largest fraction of the straight way `from` -> `to` that is proven to leave every candidate pair apart, with at
/// least the distance that `keep` asks for. Same bits on any number of threads. The candidates must
/// hold for both positions.
SafeStep find_safe_step(const BroadPhase& candidates, const Points& from, const Points& to, const KeptDistance& keep,
                        const CcdTable& table, const Threads& threads);

} // namespace wry::contact
