#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/report/plot.h"

namespace wry::pipeline {

/// The plots of a run that its tables can give: measures over time from measure.csv; energies, iterations, time steps,
/// least distances and time per phase from stats.csv. A quantity that stays zero is left out.
std::vector<Plot> run_plots(const std::filesystem::path& folder);

} // namespace wry::pipeline
