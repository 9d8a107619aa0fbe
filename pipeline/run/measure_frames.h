#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/plan/scene_plan.h"
#include "sim/base/parallel.h"
#include "sim/base/result.h"

namespace wry::pipeline {

/// What was measured: a row per frame, a column per measure.
struct MeasureTable {
  std::vector<int> frames;
  std::vector<std::string> names;
  std::vector<std::vector<double>> rows;
};

/// Measures all cached frames in `out` and writes measure.csv there, if there is anything to be measured. Errors: those
/// of the cache, cannot_write.
Result<MeasureTable> measure_frames(const ScenePlan& plan, const std::filesystem::path& out, const Threads& threads);

} // namespace wry::pipeline
