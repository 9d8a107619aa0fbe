#include "pipeline/cli/output_folder.h"

#include <fstream>

#include <fmt/format.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/report/readable.h"

namespace wry::pipeline {

namespace {

/// Memory that a new process can have without swapping [B]; 0 where the system does not say.
std::uint64_t available_memory() {
  std::ifstream info("/proc/meminfo");
  std::string word;
  while (info >> word) {
    if (word != "MemAvailable:")
      continue;
    std::uint64_t kibibytes = 0;
    info >> kibibytes;
    return kibibytes * 1024;
  }
  return 0;
}

} // namespace

Result<FolderLock> take_folder(const std::filesystem::path& folder) {
  if (Status status = prepare_folder(folder); !status)
    return status.error();
  Result<FolderLock> lock = FolderLock::acquire(folder);
  if (lock.ok() && !lock->recovered_from().empty())
    fmt::print(stderr, "warning: took over the lock of {}\n", lock->recovered_from());
  return lock;
}

Status require_resources(const ScenePlan& plan, const std::filesystem::path& folder) {
  const std::uint64_t memory = available_memory();
  if (memory > 0 && plan.cost.memory_bytes > memory)
    return make_error(ErrorCode::out_of_memory,
                      "{}: needs about {} of memory, this machine has {} left; a coarser resolution needs less",
                      plan.name, human_bytes(double(plan.cost.memory_bytes)), human_bytes(double(memory)));
  const double frame_count = plan.sim.last_frame - plan.sim.first_frame + 1;
  return require_space(folder, plan.cost.disk_bytes(frame_count), fmt::format("{:.0f} frames", frame_count));
}

} // namespace wry::pipeline
