#pragma once

#include <string>
#include <vector>

#include "shots/load.h"

namespace wry::shots {

/// One variant of a sweep: the shot with these overrides.
struct Wedge {
  int index = 0;
  std::string hash; ///< 8 hexadecimal digits of the overrides: the same parameters keep it when the sweep grows
  std::string name; ///< for people: "length_scale=0.1", or the name of the case
  std::vector<Override> overrides;

  std::string id() const; ///< "003-1f0c9a2b", the folder's name
};

/// Most wedges of one sweep.
inline constexpr std::size_t MAX_WEDGES = 10'000;

/// Every wedge of [sweep], cases outermost, then lists in the order of the file, the last one running fastest. Without
/// [sweep]: none. Each wedge's overrides are for apply_overrides. Errors: bad_input with the line: lists that are
/// empty, unequal when zipped or more than MAX_WEDGES together, keys that the shot cannot have.
Result<std::vector<Wedge>> expand_sweep(const ShotDocument& document);

} // namespace wry::shots
