#include "pipeline/run/measure_frames.h"

#include <cmath>

#include <fmt/format.h>

#include "pipeline/cache/atomic_file.h"
#include "pipeline/cache/frame_cache.h"

namespace wry::pipeline {

Result<MeasureTable> measure_frames(const ScenePlan& plan, const std::filesystem::path& out, const Threads& threads) {
  MeasureTable table;
  for (const MeasurePlan& measure : plan.measures)
    table.names.push_back(measure.name);
  Result<FrameCache> cache = FrameCache::open_to_read(out / "frames", plan.simulation_key);
  if (!cache)
    return cache.error();
  const Result<SceneStatic> scene = cache->read_static();
  if (!scene)
    return scene.error();
  std::vector<MeasurePlan> measures = plan.measures;
  std::string text = "frame,time_s";
  for (const std::string& name : table.names)
    text += "," + name;
  text += "\n";
  for (const CachedFrame& cached : cache->frames()) {
    const Result<Frame> frame = cache->read_frame(cached.number);
    if (!frame)
      return frame.error();
    std::vector<double> row(measures.size());
    threads.for_each(measures.size(), 1, [&](std::size_t i) {
      if (plan.measure_is_relative[i] && !measures[i].reference)
        measures[i].reference = evaluate_measure(measures[i], *scene, *frame);
      row[i] = measured_value(measures[i], *scene, *frame);
    });
    text += fmt::format("{},{}", frame->number, frame->time);
    for (const double value : row)
      text += std::isnan(value) ? std::string(",nan") : fmt::format(",{}", value); // no "-nan"
    text += "\n";
    table.frames.push_back(frame->number);
    table.rows.push_back(std::move(row));
  }
  if (!measures.empty()) {
    if (Status status = write_file_atomically(out / "measure.csv", text); !status)
      return status.error();
  }
  return table;
}

} // namespace wry::pipeline
