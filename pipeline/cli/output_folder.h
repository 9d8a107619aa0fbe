#pragma once

#include <filesystem>
#include <string>

#include "pipeline/run/lock.h"
#include "sim/base/result.h"

namespace wry::pipeline {

/// Makes the folder, shows that it can be written, and takes its lock. Errors: cannot_write.
Result<FolderLock> take_folder(const std::filesystem::path& folder);

} // namespace wry::pipeline
