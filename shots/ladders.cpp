#include "shots/ladders.h"

#include <cmath>

#include "shots/check.h"
#include "shots/sweep_plan.h"

namespace wry::shots {
namespace {

/// Reads one section beside its ladders.
class SectionReader {
public:
  SectionReader(const Table& root, std::string name, Diagnostics& diagnostics)
      : m_root(root)
      , m_name(std::move(name))
      , m_diagnostics(diagnostics) {
    const Value* value = root.find(m_name);
    m_table = value ? value->get<Table>() : nullptr;
  }

  std::vector<Ladder> ladders(const std::vector<std::string>& reserved) {
    std::vector<Ladder> list;
    for (const SweepAxis& axis : plan_axes(m_root, m_name, reserved, m_diagnostics)) {
      Ladder ladder{axis.key, axis.source, {}};
      for (const Value& value : axis.values) {
        ladder.values.push_back(to_toml(value));
      }
      list.push_back(std::move(ladder));
    }
    return list;
  }

  std::optional<Value> checked(const Field& field) {
    const Value* value = m_table ? m_table->find(field.key) : nullptr;
    return value ? check_value(field, *value, m_name + "." + field.key, {}, {}, m_diagnostics) : std::nullopt;
  }

  void number_key(const std::string& key, const Interval& interval, double& target) {
    if (const std::optional<Value> value = checked(number(key, "", interval, ""))) {
      target = value->number();
    }
  }

  void frames_key(std::optional<std::string>& target) {
    if (const std::optional<Value> value = checked(plain("frames", Kind::frames, ""))) {
      const auto* text = value->get<std::string>();
      target = text ? *text : to_toml(*value);
    }
  }

  /// Entries of a table whose keys are quoted whole or nested.
  std::vector<std::pair<std::string, const Value*>> entries(const std::string& key) {
    std::vector<std::pair<std::string, const Value*>> list;
    const Value* value = m_table ? m_table->find(key) : nullptr;
    if (value && !value->get<Table>()) {
      m_diagnostics.add(value->place.source(m_name + "." + key),
                        fmt::format(": this is {}; expected a table {{ key = value, ... }}", describe_type(*value)));
    } else if (value) {
      collect(*value->get<Table>(), "", list);
    }
    return list;
  }

private:
  static void collect(const Table& table, const std::string& prefix,
                      std::vector<std::pair<std::string, const Value*>>& list) {
    for (const Entry& entry : table.entries()) {
      const std::string key = prefix.empty() ? entry.key : prefix + "." + entry.key;
      if (const Table* deeper = entry.value.get<Table>()) {
        collect(*deeper, key, list);
      } else {
        list.emplace_back(key, &entry.value);
      }
    }
  }

  const Table& m_root;
  std::string m_name;
  Diagnostics& m_diagnostics;
  const Table* m_table = nullptr;
};

} // namespace

AccuracySection plan_accuracy(const Table& root, Diagnostics& diagnostics) {
  SectionReader reader(root, "accuracy", diagnostics);
  AccuracySection section;
  section.ladders = reader.ladders({"frames", "tolerance", "reference_factor", "repeats", "reference", "exact"});
  reader.frames_key(section.frames);
  reader.number_key("tolerance", strictly_between(0.0, 1.0), section.tolerance);
  reader.number_key("reference_factor", between(1.5, 1000.0), section.reference_factor);
  double repeats = section.repeats;
  reader.number_key("repeats", between(1.0, 9.0), repeats);
  section.repeats = static_cast<int>(std::lround(repeats));
  for (const auto& [key, value] : reader.entries("reference")) {
    section.reference.push_back({key, to_toml(*value), value->place.source("accuracy.reference")});
  }
  for (const auto& [key, value] : reader.entries("exact")) {
    if (value->is_number()) {
      section.exact.emplace_back(key, value->number());
    } else {
      diagnostics.add(value->place.source("accuracy.exact." + key),
                      fmt::format(": this is {}; expected a number", describe_type(*value)));
    }
  }
  return section;
}

StressSection plan_stress(const Table& root, Diagnostics& diagnostics) {
  SectionReader reader(root, "stress", diagnostics);
  StressSection section;
  section.knobs = reader.ladders({"frames", "time_limit", "pairs"});
  reader.frames_key(section.frames);
  reader.number_key("time_limit", between(0.1, 1e6), section.time_limit);
  if (const std::optional<Value> pairs = reader.checked(plain("pairs", Kind::boolean, ""))) {
    section.pairs = *pairs->get<bool>();
  }
  return section;
}

Result<AccuracySection> read_accuracy(const ShotDocument& document) {
  Diagnostics diagnostics;
  AccuracySection section = plan_accuracy(document.root(), diagnostics);
  return diagnostics.empty() ? Result<AccuracySection>(std::move(section)) : diagnostics.error();
}

Result<StressSection> read_stress(const ShotDocument& document) {
  Diagnostics diagnostics;
  StressSection section = plan_stress(document.root(), diagnostics);
  return diagnostics.empty() ? Result<StressSection>(std::move(section)) : diagnostics.error();
}

} // namespace wry::shots
