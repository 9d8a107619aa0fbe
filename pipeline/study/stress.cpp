#include "pipeline/study/stress.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "pipeline/report/csv.h"
#include "pipeline/report/csv_table.h"

namespace wry::pipeline {

namespace {

double sum_of(const CsvTable& stats, const std::string& column) {
  double sum = 0.0;
  for (const double value : stats.numbers(column))
    sum += std::isfinite(value) ? value : 0.0;
  return sum;
}

/// How much the sum of all energies grew from the first step to the last, over the largest of its parts on the way.
double energy_growth(const CsvTable& stats) {
  double first = 0.0, last = 0.0, scale = 0.0;
  for (const std::string& column : stats.columns) {
    if (!column.ends_with("_energy_J"))
      continue;
    const std::vector<double> values = stats.numbers(column);
    if (values.empty())
      return 0.0;
    first += values.front();
    last += values.back();
    for (const double value : values)
      scale = std::max(scale, std::abs(value - values.front()));
  }
  return scale > 0.0 ? (last - first) / scale : 0.0;
}

bool all_finite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

/// Columns that hold something that is no number, though they need not: infinite gaps are where nothing is near, and
/// what is not always a number in the shot as it is may be none here either (a slope where there is no heap).
bool passes_no_number(const CsvTable& table, const CsvTable& base) {
  return std::any_of(table.columns.begin(), table.columns.end(), [&](const std::string& column) {
    return column.find("distance") == std::string::npos && !all_finite(table.numbers(column)) &&
           all_finite(base.numbers(column));
  });
}

StressFinding finding_of(const StudyRow& row, const std::filesystem::path& base, double base_steps) {
  StressFinding finding;
  finding.message = row.reason;
  const CsvTable stats = read_csv_table(row.folder / "stats.csv");
  finding.cuts = sum_of(stats, "cuts");
  finding.slower = base_steps > 0.0 ? static_cast<double>(stats.rows.size()) / base_steps : 0.0;
  finding.energy_growth = energy_growth(stats);
  finding.least_distance = std::numeric_limits<double>::infinity();
  for (const double distance : stats.numbers("least_distance_m"))
    finding.least_distance =
        std::isfinite(distance) ? std::min(finding.least_distance, distance) : finding.least_distance;
  if (row.outcome == StudyOutcome::done) {
    finding.mark = finding.cuts > 0.0 ? MapMark::holds_with_smaller_steps : MapMark::holds;
    if (passes_no_number(stats, {}) ||
        passes_no_number(read_csv_table(row.folder / "measure.csv"), read_csv_table(base / "measure.csv"))) {
      finding.mark = MapMark::fails;
      finding.message = "a value that is no number was passed as good";
    }
  } else if (row.timed_out) {
    finding.mark = MapMark::unfinished;
  } else if (row.outcome == StudyOutcome::failed) {
    // Clear refusals: a bad value, a solver that gave up with numbers, too little memory. All else is a failure of
    // ours.
    const int code = row.exit_code;
    const bool clear = code == 65 || code == 69 || code == 70 || code == 71;
    finding.mark = clear && !row.reason.empty() ? MapMark::refuses : MapMark::fails;
  }
  return finding;
}

std::string cell_text(const StressFinding& finding) {
  switch (finding.mark) {
  case MapMark::holds_with_smaller_steps:
    return fmt::format("{:.2g}x", finding.slower);
  case MapMark::refuses:
    return "refused";
  case MapMark::fails:
    return "FAILS";
  default:
    return {};
  }
}

/// From worst to best, for a cell that stands for several cases.
int badness(MapMark mark) {
  return static_cast<int>(mark);
}

std::string safe_range(const StressStudy& study, const StressReport& report, std::size_t knob) {
  std::string text;
  for (std::size_t c = 0; c < study.cases.size(); ++c) {
    if (study.cases[c].knobs != std::vector<std::size_t>{knob})
      continue;
    const MapMark mark = report.findings[c].mark;
    if (mark == MapMark::holds || mark == MapMark::holds_with_smaller_steps)
      text += (text.empty() ? "" : ", ") + value_label(study.knobs[knob], study.cases[c].values[0]);
  }
  return fmt::format("{}: {}", study.knobs[knob].key,
                     text.empty() ? "at none of the values tried" : "holds at " + text);
}

} // namespace

StressReport judge_stress(const StressStudy& study, const std::vector<StudyRow>& rows) {
  StressReport report;
  const std::filesystem::path base = rows[study.base].folder;
  const double base_steps = static_cast<double>(read_csv_table(base / "stats.csv").rows.size());
  for (const StressCase& one : study.cases) {
    report.findings.push_back(finding_of(rows[one.row], base, base_steps));
    report.failures += report.findings.back().mark == MapMark::fails ? 1 : 0;
  }
  for (std::size_t knob = 0; knob < study.knobs.size(); ++knob)
    report.safe.push_back(safe_range(study, report, knob));
  return report;
}

std::string stress_csv(const StressStudy& study, const std::vector<StudyRow>& rows, const StressReport& report) {
  std::string text = "case,outcome,exit_code,steps_over_base,cuts,energy_growth,least_distance_m,cpu_s,message\n";
  for (std::size_t c = 0; c < study.cases.size(); ++c) {
    const StudyRow& row = rows[study.cases[c].row];
    const StressFinding& finding = report.findings[c];
    const char* word = finding.mark == MapMark::holds                      ? "holds"
                       : finding.mark == MapMark::holds_with_smaller_steps ? "holds with smaller steps"
                       : finding.mark == MapMark::refuses                  ? "refuses"
                       : finding.mark == MapMark::unfinished               ? "not done in its time"
                       : finding.mark == MapMark::fails                    ? "fails"
                                                                           : "not run";
    text += fmt::format("{},{},{},{:.3g},{:g},{:.3g},{:.3g},{:.3f},{}\n", csv_field(row.variant.name), word,
                        row.exit_code, finding.slower, finding.cuts, finding.energy_growth, finding.least_distance,
                        row.cpu_seconds, csv_field(finding.message));
  }
  return text;
}

MapPlot stress_map(const StressStudy& study, const StressReport& report, const std::string& shot) {
  MapPlot map{shot + ": one knob at a time", {}, {}, {}};
  std::size_t most = 0;
  for (const shots::Ladder& knob : study.knobs) {
    map.rows.push_back(knob.key);
    most = std::max(most, knob.values.size());
  }
  map.columns.assign(most, "");
  map.cells.resize(study.knobs.size());
  for (std::size_t c = 0; c < study.cases.size(); ++c) {
    const StressCase& one = study.cases[c];
    if (one.knobs.size() != 1)
      continue;
    const std::string detail = cell_text(report.findings[c]);
    map.cells[one.knobs[0]].push_back({report.findings[c].mark, value_label(study.knobs[one.knobs[0]], one.values[0]) +
                                                                    (detail.empty() ? "" : "  " + detail)});
  }
  return map;
}

namespace {

/// The last word of a knob's key; of an axis, what it is the axis of as well.
std::string short_name(const std::string& key) {
  std::size_t dot = key.rfind('.');
  if (dot != std::string::npos && key.size() - dot <= 2)
    dot = key.rfind('.', dot - 1);
  return key.substr(dot + 1);
}

} // namespace

MapPlot stress_pairs_map(const StressStudy& study, const StressReport& report, const std::string& shot) {
  MapPlot map{shot + ": two knobs at their ends: how many of four hold, and the worst", {}, {}, {}};
  for (const shots::Ladder& knob : study.knobs) {
    map.rows.push_back(knob.key);
    map.columns.push_back(short_name(knob.key));
  }
  map.cells.assign(study.knobs.size(), std::vector<MapCell>(study.knobs.size()));
  struct Count {
    int cases = 0, held = 0;
  };
  std::map<std::pair<std::size_t, std::size_t>, Count> counts;
  for (std::size_t c = 0; c < study.cases.size(); ++c) {
    const StressCase& one = study.cases[c];
    if (one.knobs.size() != 2)
      continue;
    const MapMark mark = report.findings[c].mark;
    Count& count = counts[std::minmax(one.knobs[0], one.knobs[1])];
    count.cases += mark != MapMark::none ? 1 : 0;
    count.held += mark == MapMark::holds || mark == MapMark::holds_with_smaller_steps ? 1 : 0;
    MapCell& cell = map.cells[one.knobs[0]][one.knobs[1]];
    if (badness(mark) > badness(cell.mark))
      cell.mark = mark;
    cell.text = count.cases > 0 ? fmt::format("{} of {}", count.held, count.cases) : std::string();
    map.cells[one.knobs[1]][one.knobs[0]] = cell;
  }
  // Knobs that are turned alone only have no pairs.
  for (std::size_t knob = study.knobs.size(); knob-- > 0;) {
    const bool paired = std::any_of(counts.begin(), counts.end(), [&](const auto& entry) {
      return entry.first.first == knob || entry.first.second == knob;
    });
    if (paired)
      continue;
    const auto at = static_cast<std::ptrdiff_t>(knob);
    map.rows.erase(map.rows.begin() + at);
    map.columns.erase(map.columns.begin() + at);
    map.cells.erase(map.cells.begin() + at);
    for (std::vector<MapCell>& row : map.cells)
      row.erase(row.begin() + at);
  }
  return map;
}

} // namespace wry::pipeline
