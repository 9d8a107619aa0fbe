#pragma once

#include <functional>

#include "sim/base/result.h"

namespace wry::render {

/// Work that is shared out over processes; one process per core draws faster than threads in one.
struct PooledWork {
  int count = 0;     ///< indices 0 ... count - 1, each done once
  int processes = 1; ///< [1, 256]; never more than `count` are made
  /// Called once in each child; returns what does one index, e.g. a lambda that owns a Renderer.
  std::function<Result<std::function<Status(int)>>()> prepare;
  /// Called in the parent after each index that succeeded, in the order of their ends; may be empty.
  std::function<void(int)> done;
  /// Asked in the parent a few times a second; true: no further index is begun. May be empty.
  std::function<bool()> should_stop;
};

/// Forks the children, waits for all. The caller must have no threads that hold locks and no Renderer with raster
/// threads. Errors: that of the lowest index that failed (no further index is begun after a failure), stopped when
/// should_stop said so, out_of_memory when a child was killed, io when it crashed.
Status run_in_processes(const PooledWork& work);

} // namespace wry::render
