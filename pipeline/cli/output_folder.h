#pragma once

#include <filesystem>
#include <string>

#include "pipeline/plan/scene_plan.h"
#include "pipeline/run/lock.h"
#include "sim/base/result.h"

namespace wry::pipeline {

/// Makes the folder, shows that it can be written, and takes its lock. Errors: cannot_write.
Result<FolderLock> take_folder(const std::filesystem::path& folder);

/// Refuses a scene that needs more memory or disk than there is. Errors: out_of_memory, cannot_write, with the numbers.
Status require_resources(const ScenePlan& plan, const std::filesystem::path& folder);

} // namespace wry::pipeline
