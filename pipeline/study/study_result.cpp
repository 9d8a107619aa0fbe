#include "pipeline/study/study_result.h"

#include <algorithm>
#include <vector>

#include "pipeline/cache/frame_cache.h"
#include "pipeline/cache/verified_folder.h"
#include "pipeline/report/csv_table.h"
#include "pipeline/run/render_frames.h"

namespace wry::pipeline {

namespace {

namespace fs = std::filesystem;

double median_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

/// Sums up what a variant's jobs took; repeats count by their median.
class Timing {
public:
  void take(const Job& job, const JobRecord& record, StudyRow& row) {
    row.peak_bytes = std::max(row.peak_bytes, record.peak_bytes);
    if (job.stage.starts_with("timing-")) {
      m_cpu.push_back(record.cpu_seconds);
      m_wall.push_back(record.wall_seconds);
    } else {
      row.cpu_seconds += record.cpu_seconds;
      row.wall_seconds += record.wall_seconds;
    }
  }

  void finish(StudyRow& row) {
    if (m_cpu.empty())
      return;
    m_cpu.push_back(row.cpu_seconds);
    m_wall.push_back(row.wall_seconds);
    row.cpu_seconds = median_of(m_cpu);
    row.wall_seconds = median_of(m_wall);
    const auto [least, most] = std::minmax_element(m_cpu.begin(), m_cpu.end());
    row.timing_spread = row.cpu_seconds > 0.0 ? (*most - *least) / row.cpu_seconds : 0.0;
  }

private:
  std::vector<double> m_cpu, m_wall;
};

/// What a job that did not end with 0 means for its variant.
void take_failure(const Job& job, const JobRecord& record, StudyRow& row) {
  row.exit_code = record.exit_code;
  row.timed_out = record.timed_out;
  row.reason = record.reason;
  if (record.exit_code == static_cast<int>(ErrorCode::stopped) && !record.timed_out)
    row.outcome = StudyOutcome::stopped;
  else if (record.exit_code == static_cast<int>(ErrorCode::check_failed) && job.stage == "finish")
    row.outcome = StudyOutcome::expectation_failed;
  else
    row.outcome = StudyOutcome::failed;
}

} // namespace

Status verify_outputs(const StudyRequest& request, const StudyRow& row) {
  const fs::path frames = row.folder / "frames";
  const Result<FrameCache> cache = FrameCache::open_to_read(frames);
  if (!cache)
    return cache.error();
  for (const int frame : row.frames) {
    if (!cache->has_frame(frame))
      return make_error(ErrorCode::missing_input, "frame {} is not in the manifest of {}", frame, frames.string());
  }
  const Result<FolderReport> report = check_folder(frames);
  if (!report)
    return report.error();
  for (const FolderFinding& finding : report->findings) {
    if (is_damage(finding.kind))
      return make_error(ErrorCode::io, "{}", finding.message);
  }
  if (request.stages == StudyStages::simulate)
    return {};
  for (const shots::Located<shots::View>& view : row.shot->render.views) {
    for (const int frame : row.frames) {
      const fs::path picture = picture_path(row.folder, *row.shot->shot.name, view->name, frame);
      std::error_code ignored;
      if (const std::uintmax_t size = fs::file_size(picture, ignored); ignored || size == 0)
        return make_error(ErrorCode::missing_input, "{} is not there", picture.string());
    }
  }
  return {};
}

void read_outcome(const StudyRequest& request, const std::vector<Job>& jobs, StudyRow& row) {
  row.outcome = StudyOutcome::done;
  Timing timing;
  for (const Job& job : jobs) {
    const Result<JobRecord> record = read_job_record(job);
    if (!record) {
      row.outcome = StudyOutcome::not_run;
      row.reason = job.stage + " was not run";
      break;
    }
    timing.take(job, *record, row);
    if (record->exit_code != 0) {
      take_failure(job, *record, row);
      break;
    }
  }
  timing.finish(row);
  if (is_finished(row.outcome)) {
    if (const Status whole = verify_outputs(request, row); !whole) {
      row.outcome = StudyOutcome::failed;
      row.reason = "its jobs say that it is done, but " + whole.error().message;
    }
  }
  const CsvTable measures = read_csv_table(row.folder / "measure.csv");
  if (row.outcome == StudyOutcome::not_run || measures.rows.empty())
    return;
  for (std::size_t i = 0; i < std::min(measures.columns.size(), measures.rows.back().size()); ++i)
    row.measures.emplace_back(measures.columns[i], measures.rows.back()[i]);
}

} // namespace wry::pipeline
