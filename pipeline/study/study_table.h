#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/study/study.h"

namespace wry::pipeline {

/// Keys that variants of a study set, in the order of their first appearance.
std::vector<std::string> parameter_keys(const std::vector<StudyRow>& rows);
/// What a variant gives a key, as a person writes it; empty: nothing.
std::string parameter_value(const Variant& variant, const std::string& key);

/// A key of a study and the values that it takes.
struct ParameterAxis {
  std::string key;
  std::string label; ///< the last part of the key, or the whole key where two end alike
  bool numeric = false;
  std::vector<std::string> values; ///< numbers ascending, words in the order of their first appearance
};
std::vector<ParameterAxis> parameter_axes(const std::vector<StudyRow>& rows);

/// A study as a table of pictures: one parameter across, all others down.
struct StudyGrid {
  std::vector<std::size_t> order; ///< of the rows, from left to right and from top to bottom
  std::vector<std::string> column_heads, row_heads;
};
/// Nothing where the variants are not each combination of two or more parameters once.
std::optional<StudyGrid> study_grid(const std::vector<StudyRow>& rows);

/// Columns of measures that any variant has, without frame and time.
std::vector<std::string> measure_names(const std::vector<StudyRow>& rows);
/// A measure's last value; nullptr: there is none.
const std::string* find_measure(const StudyRow& row, const std::string& name);

/// The study as CSV: a row per variant with its parameters, what came of it, its measures and what it cost.
std::string study_csv(const std::vector<StudyRow>& rows);

/// "20 done, 1 failed, 3 not run"
std::string study_summary(const std::vector<StudyRow>& rows);

/// A line per variant that is not done, with its reason; empty when all are.
std::string study_failures(const std::vector<StudyRow>& rows);

} // namespace wry::pipeline
