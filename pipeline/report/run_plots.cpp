#include "pipeline/report/run_plots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "pipeline/report/csv_table.h"

namespace wry::pipeline {

namespace {

constexpr std::size_t MOST_POINTS = 1500; ///< of a curve: more is no sharper on a screen

/// Which columns of stats.csv stand in one plot: those whose name ends like this.
struct StatsPlot {
  const char* title;
  const char* y_label;
  std::string_view ending;
  PlotScale scale;
};

constexpr std::array STATS_PLOTS = {
    StatsPlot{"Energies", "energy [J]", "_energy_J", PlotScale::linear},
    StatsPlot{"Iterations per step", "count", "_iterations", PlotScale::linear},
    StatsPlot{"Time step", "dt [s]", "dt_s", PlotScale::logarithmic},
    StatsPlot{"Contacts", "count", "contacts", PlotScale::linear},
    StatsPlot{"Least gap", "distance [m]", "least_distance_m", PlotScale::logarithmic},
    StatsPlot{"Residual at the end of a step", "residual [N s]", "residual_Ns", PlotScale::logarithmic},
    StatsPlot{"Time per step and phase", "time [ms]", "_ms", PlotScale::linear},
};

std::vector<double> thinned(const std::vector<double>& values, std::size_t stride) {
  std::vector<double> kept;
  for (std::size_t i = 0; i < values.size(); i += stride)
    kept.push_back(values[i]);
  return kept;
}

bool worth_showing(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v) && v != 0.0; });
}

/// "elastic" from "elastic_energy_J"
std::string series_label(const std::string& column, std::string_view ending) {
  const std::string label = column.substr(0, column.size() - std::min(ending.size(), column.size()));
  return label.empty() ? column : label;
}

} // namespace

std::vector<Plot> run_plots(const std::filesystem::path& folder) {
  std::vector<Plot> plots;
  const CsvTable measures = read_csv_table(folder / "measure.csv");
  const std::vector<double> frame_times = measures.numbers("time_s");
  for (const std::string& column : measures.columns) {
    const std::vector<double> values = measures.numbers(column);
    if (column != "frame" && column != "time_s" && worth_showing(values))
      plots.push_back({column,
                       "time [s]",
                       "",
                       PlotScale::linear,
                       PlotScale::linear,
                       {{"", frame_times, values, PlotMark::line, {}}},
                       560,
                       280});
  }
  const CsvTable stats = read_csv_table(folder / "stats.csv");
  const std::vector<double> times = stats.numbers("time_s");
  const std::size_t stride = 1 + times.size() / MOST_POINTS;
  for (const StatsPlot& kind : STATS_PLOTS) {
    Plot plot{kind.title, "time [s]", kind.y_label, PlotScale::linear, kind.scale, {}, 560, 320};
    for (const std::string& column : stats.columns) {
      const std::vector<double> values = stats.numbers(column);
      if (column.ends_with(kind.ending) && worth_showing(values))
        plot.series.push_back(
            {series_label(column, kind.ending), thinned(times, stride), thinned(values, stride), PlotMark::line, {}});
    }
    if (plot.series.size() == 1)
      plot.series.front().label.clear();
    if (!plot.series.empty())
      plots.push_back(std::move(plot));
  }
  return plots;
}

} // namespace wry::pipeline
