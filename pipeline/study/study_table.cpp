#include "pipeline/study/study_table.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "pipeline/report/csv.h"
#include "pipeline/report/csv_table.h"

namespace wry::pipeline {

namespace {

void add_once(std::vector<std::string>& list, const std::string& word) {
  if (std::find(list.begin(), list.end(), word) == list.end())
    list.push_back(word);
}

std::string label_of(const std::string& key, const std::vector<std::string>& keys) {
  const auto last = [](const std::string& k) { return k.substr(k.rfind('.') + 1); };
  const auto alike =
      std::count_if(keys.begin(), keys.end(), [&](const std::string& other) { return last(other) == last(key); });
  return alike > 1 ? key : last(key);
}

std::size_t position_of(const ParameterAxis& axis, const StudyRow& row) {
  const std::string value = parameter_value(row.variant, axis.key);
  return static_cast<std::size_t>(std::find(axis.values.begin(), axis.values.end(), value) - axis.values.begin());
}

/// "friction 0.3"; names of cases speak for themselves.
std::string head_of(const ParameterAxis& axis, const std::string& value) {
  return axis.key == "case" ? value : fmt::format("{} {}", axis.label, value.empty() ? "-" : value);
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

std::vector<ParameterAxis> parameter_axes(const std::vector<StudyRow>& rows) {
  std::vector<ParameterAxis> axes;
  const std::vector<std::string> keys = parameter_keys(rows);
  for (const std::string& key : keys) {
    ParameterAxis axis{key, label_of(key, keys), true, {}};
    for (const StudyRow& row : rows)
      add_once(axis.values, parameter_value(row.variant, key));
    axis.numeric = std::all_of(axis.values.begin(), axis.values.end(),
                               [](const std::string& value) { return std::isfinite(number_of(value)); });
    if (axis.numeric)
      std::sort(axis.values.begin(), axis.values.end(),
                [](const std::string& a, const std::string& b) { return number_of(a) < number_of(b); });
    axes.push_back(std::move(axis));
  }
  return axes;
}

std::optional<StudyGrid> study_grid(const std::vector<StudyRow>& rows) {
  std::vector<ParameterAxis> axes = parameter_axes(rows);
  std::erase_if(axes, [](const ParameterAxis& axis) { return axis.values.size() < 2; });
  if (axes.size() < 2)
    return std::nullopt;
  // The longest goes across.
  const auto across = std::max_element(axes.begin(), axes.end(), [](const ParameterAxis& a, const ParameterAxis& b) {
    return a.values.size() < b.values.size();
  });
  std::rotate(axes.begin(), across, across + 1);
  std::vector<std::size_t> place(rows.size(), 0);
  std::size_t cells = 1;
  for (std::size_t a = axes.size(); a-- > 0;) {
    for (std::size_t row = 0; row < rows.size(); ++row)
      place[row] += cells * (a == 0 ? 0 : position_of(axes[a], rows[row]));
    cells *= a == 0 ? 1 : axes[a].values.size();
  }
  const std::size_t columns = axes.front().values.size();
  if (cells * columns != rows.size())
    return std::nullopt;
  StudyGrid grid;
  grid.order.assign(rows.size(), rows.size());
  grid.row_heads.resize(cells);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    std::size_t& there = grid.order[place[row] * columns + position_of(axes.front(), rows[row])];
    if (there < rows.size())
      return std::nullopt;
    there = row;
    std::string head;
    for (std::size_t a = 1; a < axes.size(); ++a)
      head += (a > 1 ? ", " : "") + head_of(axes[a], parameter_value(rows[row].variant, axes[a].key));
    grid.row_heads[place[row]] = head;
  }
  for (const std::string& value : axes.front().values)
    grid.column_heads.push_back(head_of(axes.front(), value));
  return grid;
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
