#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "shots/shot.h"
#include "sim/base/parallel.h"
#include "sim/base/result.h"

namespace wry::pipeline {

/// What an exact look at the solids of every saved frame found.
struct IntersectionReport {
  int frames = 0;                    ///< that were looked at
  std::vector<std::string> findings; ///< a sentence per frame in which surfaces intersect or touch
};

/// Tests every frame of `out`/frames for intersections of the solids' surfaces, with each other and with themselves as
/// the shot's [contact] has it, exactly (adaptive predicates; touching counts). No frames are looked at without
/// [contact]. Errors: those of reading frames.
Result<IntersectionReport> find_intersections(const shots::Shot& shot, const std::filesystem::path& out,
                                              const Threads& threads);

} // namespace wry::pipeline
