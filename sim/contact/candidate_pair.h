#pragma once

#include <array>
#include <cstdint>

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

} // namespace wry::contact
