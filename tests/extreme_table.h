#pragma once

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace wry::test {

/// One case of the extreme suite and how it went: a row of the table of docs/stability.md.
struct ExtremeRow {
  std::string outcome = "holds"; ///< "holds", "shorter steps", "refuses"
  int steps = 0;
  int iterations = 0; ///< of Newton, or linear ones of semi-implicit steps
  int cuts = 0;       ///< steps that were tried with a longer dt before
  double worst_residual = 0.0;
  std::string said; ///< by a refusal
};

/// Appends a row to the file that WRY_EXTREMES_TABLE names, if it does: tests/evidence/extremes.sh makes the table.
inline void note_extreme(const std::string& list, const std::string& name, const ExtremeRow& row) {
  const char* path = std::getenv("WRY_EXTREMES_TABLE");
  std::FILE* file = path != nullptr ? std::fopen(path, "a") : nullptr;
  if (file == nullptr)
    return;
  std::string said = row.said.substr(0, row.said.find('\n'));
  std::replace(said.begin(), said.end(), '"', '\'');
  std::fprintf(file, "%s,\"%s\",%s,%d,%d,%d,%.2g,\"%s\"\n", list.c_str(), name.c_str(), row.outcome.c_str(), row.steps,
               row.iterations, row.cuts, row.worst_residual, said.c_str());
  std::fclose(file);
}

} // namespace wry::test
