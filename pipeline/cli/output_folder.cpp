#include "pipeline/cli/output_folder.h"

#include <fmt/format.h>

#include "pipeline/cache/atomic_file.h"

namespace wry::pipeline {

Result<FolderLock> take_folder(const std::filesystem::path& folder) {
  if (Status status = prepare_folder(folder); !status)
    return status.error();
  Result<FolderLock> lock = FolderLock::acquire(folder);
  if (lock.ok() && !lock->recovered_from().empty())
    fmt::print(stderr, "warning: took over the lock of {}\n", lock->recovered_from());
  return lock;
}

} // namespace wry::pipeline
