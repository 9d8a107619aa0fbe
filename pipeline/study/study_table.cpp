#include "pipeline/study/study_table.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "pipeline/report/csv.h"

namespace wry::pipeline {

namespace {

void add_once(std::vector<std::string>& list, const std::string& word) {
  if (std::find(list.begin(), list.end(), word) == list.end())
    list.push_back(word);
}

} // namespace

std::vector<std::string> parameter_keys(const std::vector<StudyRow>& rows) {
  std::vector<std::string> keys;
  for (const StudyRow& row : rows) {
    for (const Parameter& parameter : row.variant.parameters)
      add_once(keys, parameter.key);
  }
  return keys;
}

std::string parameter_value(const Variant& variant, const std::string& key) {
  for (const Parameter& parameter : variant.parameters) {
    if (parameter.key == key)
      return plain_value(parameter.value);
  }
  return {};
}

std::vector<std::string> measure_names(const std::vector<StudyRow>& rows) {
  std::vector<std::string> names;
  for (const StudyRow& row : rows) {
    for (const auto& [name, value] : row.measures) {
      if (name != "frame" && name != "time_s")
        add_once(names, name);
    }
  }
  return names;
}

const std::string* find_measure(const StudyRow& row, const std::string& name) {
  for (const auto& [column, value] : row.measures) {
    if (column == name)
      return &value;
  }
  return nullptr;
}

std::string study_csv(const std::vector<StudyRow>& rows) {
  const std::vector<std::string> keys = parameter_keys(rows), names = measure_names(rows);
  std::string text = "wedge,name";
  for (const std::string& key : keys)
    text += "," + csv_field(key);
  text += ",outcome,exit_code,reason";
  for (const std::string& name : names)
    text += "," + csv_field(name);
  text += ",wall_s,cpu_s,peak_MiB\n";
  for (const StudyRow& row : rows) {
    text += row.variant.id() + "," + csv_field(row.variant.name);
    for (const std::string& key : keys)
      text += "," + csv_field(parameter_value(row.variant, key));
    text += fmt::format(",{},{},{}", outcome_name(row.outcome), row.exit_code, csv_field(row.reason));
    for (const std::string& name : names) {
      const std::string* value = find_measure(row, name);
      text += "," + (value != nullptr ? *value : std::string());
    }
    text += fmt::format(",{:.3f},{:.3f},{:.1f}\n", row.wall_seconds, row.cpu_seconds,
                        static_cast<double>(row.peak_bytes) / 1048576.0);
  }
  return text;
}

std::string study_summary(const std::vector<StudyRow>& rows) {
  constexpr std::array OUTCOMES = {StudyOutcome::done, StudyOutcome::expectation_failed, StudyOutcome::failed,
                                   StudyOutcome::stopped, StudyOutcome::not_run};
  std::string text;
  for (const StudyOutcome outcome : OUTCOMES) {
    const auto count = std::count_if(rows.begin(), rows.end(), [&](const StudyRow& r) { return r.outcome == outcome; });
    if (count > 0)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, outcome_name(outcome));
  }
  return text.empty() ? "nothing" : text;
}

std::string study_failures(const std::vector<StudyRow>& rows) {
  std::string text;
  for (const StudyRow& row : rows) {
    if (row.outcome != StudyOutcome::done)
      text += fmt::format("  {} ({}): {}{}{}\n", row.variant.id(), row.variant.name, outcome_name(row.outcome),
                          row.reason.empty() ? "" : ": ", row.reason);
  }
  return text;
}

} // namespace wry::pipeline
