#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "shots/diagnostics.h"
#include "shots/tree.h"

namespace wry::shots {

/// A range { from, to, count, scale }: of an axis that is not listed.
struct SweepRange {
  double from = 0.0, to = 1.0;
  bool logarithmic = false;
};

/// One parameter of a sweep.
struct SweepAxis {
  std::string key;
  Source source;
  std::vector<Value> values;       ///< empty: a latin hypercube draws them from the range
  std::optional<SweepRange> range; ///< as given
};

struct SweepCase {
  std::string name;
  Source source;
  std::vector<std::pair<std::string, Value>> set;
};

enum class SweepMode { grid, zip, latin_hypercube };

/// [sweep] as it stands, not yet multiplied out.
struct SweepPlan {
  SweepMode mode = SweepMode::grid;
  std::size_t samples = 0; ///< of a latin hypercube
  std::vector<SweepAxis> axes;
  std::vector<SweepCase> cases;
};

/// Reads [sweep] from an unchecked document; what is wrong goes to `diagnostics`. Without [sweep]: nothing.
SweepPlan plan_sweep(const Table& root, Diagnostics& diagnostics);

/// The axes of another section that is written like [sweep]: every key but the reserved ones is a key of this shot with
/// a list of values or a range. What is wrong goes to `diagnostics`. Without that section: nothing.
std::vector<SweepAxis> plan_axes(const Table& root, const std::string& section,
                                 const std::vector<std::string>& reserved, Diagnostics& diagnostics);

} // namespace wry::shots
