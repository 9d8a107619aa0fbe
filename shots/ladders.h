#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "shots/diagnostics.h"
#include "shots/load.h"
#include "shots/tree.h"

namespace wry::shots {

/// One key of the shot with the values that a report tries, as TOML.
struct Ladder {
  std::string key;
  Source source;
  std::vector<std::string> values;
  std::vector<std::string> labels{}; ///< of the values, for people; empty: the values themselves
};

/// [accuracy]: ladders from coarse to fine, and what they are held against.
struct AccuracySection {
  std::optional<std::string> frames;
  double tolerance = 0.01;       ///< relative error that the recommendation is for
  double reference_factor = 4.0; ///< how much finer than its finest rung a ladder's reference is
  int repeats = 1;               ///< runs of each rung, of whose times the median counts
  std::vector<Ladder> ladders;
  std::vector<Override> reference;                   ///< one reference for every ladder; empty: each its own
  std::vector<std::pair<std::string, double>> exact; ///< measures whose last value is known
};

/// [stress]: knobs and how far they are turned.
struct StressSection {
  std::optional<std::string> frames;
  double time_limit = 60.0; ///< [s] of each case
  bool pairs = true;
  std::vector<Ladder> knobs; ///< empty: those that the shot has
};

/// Reads [accuracy] or [stress]; what is wrong goes to `diagnostics`. Without the section: the defaults.
AccuracySection plan_accuracy(const Table& root, Diagnostics& diagnostics);
StressSection plan_stress(const Table& root, Diagnostics& diagnostics);

/// The same from a document. Errors: bad_input with the lines.
Result<AccuracySection> read_accuracy(const ShotDocument& document);
Result<StressSection> read_stress(const ShotDocument& document);

} // namespace wry::shots
