#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/base/result.h"

namespace wry::pipeline {

/// What this process may have in all of memory or of a disk under one limit: what it has already, and what is left.
struct Room {
  std::uint64_t bytes = 0;
  std::string whose; ///< as in "only 1 GiB of ... are left", for example "this machine's memory"
};

/// What a run finds. No limit: nothing is known of any, and nothing is refused for it.
struct Machine {
  std::vector<Room> memory, disk;
};

/// Where Linux says so; other places for tests.
struct SystemFiles {
  std::filesystem::path processes = "/proc";
  std::filesystem::path control_groups = "/sys/fs/cgroup";
};

/// Free memory, the control groups' limits of both versions, `ulimit -v`, and the disk of `folder`, which exists. What
/// frames, checkpoints and fields an earlier run left there counts as room: it is kept or replaced. Errors: io.
Result<Machine> read_machine(const std::filesystem::path& folder, const SystemFiles& files = {});

} // namespace wry::pipeline
