#pragma once

#include <cstdint>
#include <string>

namespace wry::shots {

/// What became of a number of broken shots.
struct MutationCounts {
  int accepted = 0, refused = 0, syntax = 0;
};

/// Breaks the texts of every_key.toml and of a small shot in `count` seeded ways, loads each, and fails the running
/// test when an error has no file:line:column and key, or an accepted shot does not survive being written out.
MutationCounts load_mutations(std::uint64_t seed, int count);

/// The same with broken --set key=value on a shot that is right.
MutationCounts set_mutations(std::uint64_t seed, int count);

} // namespace wry::shots
