#pragma once

#include <cstdint>

#include "sim/base/result.h"

namespace wry::pipeline {

/// What a process that reads foreign files may use.
struct SandboxLimits {
  std::uint64_t memory_bytes = 2ULL << 30; ///< address space
  int cpu_seconds = 10;
  int wall_seconds = 20; ///< kept by the parent
};

/// Limits this process for good: address space, processor time, no file may grow, no core dump, no new privileges,
/// killed when its parent dies. Opening and reading still work. Error io when the system refuses one of them.
Status limit_resources(const SandboxLimits& limits);

/// From here on only memory, reading and writing what is already open, and exit: no open, no socket, no exec, no fork,
/// no signals to others; all else fails with EPERM. Error unavailable where the kernel has no system-call filter.
Status forbid_system_calls();

} // namespace wry::pipeline
