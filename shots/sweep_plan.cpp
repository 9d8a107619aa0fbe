#include "shots/sweep_plan.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "shots/check.h"
#include "shots/key_path.h"
#include "shots/nearest.h"
#include "shots/sweep.h"

namespace wry::shots {
namespace {

bool is_named(Kind kind) {
  return kind == Kind::named_list || kind == Kind::named_tables;
}

/// Whether the schema has this key, or one above it. Errors: bad_input, without a place.
Status check_schema_key(const std::string& key) {
  const Result<std::vector<std::string>> parts = split_key(key);
  if (!parts) {
    return parts.error();
  }
  const Section* section = &shot_schema();
  bool is_name = false; // the part is a name of the user's
  for (const std::string& part : *parts) {
    if (is_name || (!part.empty() && part.find_first_not_of("0123456789") == std::string::npos)) {
      is_name = false;
      continue;
    }
    const Field* field = section ? section->find(part) : nullptr;
    if (!field) {
      return make_error(ErrorCode::bad_input, "there is no key '{}' in a shot{}", excerpt(key),
                        section ? suggestion(part, section->keys()) : std::string());
    }
    section = field->section.get();
    is_name = is_named(field->kind);
  }
  return {};
}

/// Reads [sweep] part by part.
class SweepReader {
public:
  SweepReader(const Table& root, std::string section, Diagnostics& diagnostics)
      : m_root(root)
      , m_section(std::move(section))
      , m_diagnostics(diagnostics) {}

  std::vector<SweepAxis> read_axes(const std::vector<std::string>& reserved) {
    const Value* value = m_root.find(m_section);
    const Table* table = value ? value->get<Table>() : nullptr;
    if (table) {
      for (const Entry& entry : table->entries()) {
        if (std::find(reserved.begin(), reserved.end(), entry.key) == reserved.end()) {
          read_axis(entry.key, entry.value);
        }
      }
    }
    return std::move(m_plan.axes);
  }

  SweepPlan read() {
    const Value* value = m_root.find("sweep");
    const Table* sweep = value ? value->get<Table>() : nullptr;
    if (!sweep) {
      return {}; // a [sweep] that is no table is refused with the other types
    }
    read_mode(*sweep);
    for (const Entry& entry : sweep->entries()) {
      if (entry.key == "case") {
        read_cases(entry.value);
      } else if (entry.key != "mode" && entry.key != "samples" && entry.key != "applied") {
        read_axis(entry.key, entry.value);
      }
    }
    return std::move(m_plan);
  }

private:
  void refuse(const Value& value, const std::string& key, const std::string& message) {
    m_diagnostics.add(value.place.source(key), message);
  }

  void read_mode(const Table& sweep) {
    const Field mode = choice("mode", {{"grid", "", ""}, {"zip", "", ""}, {"latin-hypercube", "", ""}}, "");
    if (const Value* value = sweep.find("mode")) {
      if (const auto word = check_value(mode, *value, "sweep.mode", {}, {}, m_diagnostics)) {
        const std::string& name = *word->get<std::string>();
        m_plan.mode = name == "zip" ? SweepMode::zip : name == "grid" ? SweepMode::grid : SweepMode::latin_hypercube;
      }
    }
    const Value* samples = sweep.find("samples");
    if (samples) {
      const Field count = integer("samples", between(1, static_cast<double>(MAX_WEDGES)), "");
      if (const auto number = check_value(count, *samples, "sweep.samples", {}, {}, m_diagnostics)) {
        m_plan.samples = static_cast<std::size_t>(*number->get<std::int64_t>());
      }
    } else if (m_plan.mode == SweepMode::latin_hypercube) {
      refuse(*sweep.find("mode"), "sweep.samples", " is missing: a latin hypercube needs the number of wedges");
    }
  }

  static bool is_range(const Table& table) { return table.find("from") || table.find("to"); }

  /// Quoted keys, or the same keys without quotes, which TOML reads as nested tables.
  void read_axis(const std::string& key, const Value& value) {
    const Table* table = value.get<Table>();
    if (table && !is_range(*table)) {
      for (const Entry& entry : table->entries()) {
        read_axis(key + "." + entry.key, entry.value);
      }
      return;
    }
    const std::string path = m_section + "." + to_toml_key(key);
    SweepAxis axis{key, value.place.source(path), {}, {}};
    if (table ? read_range(*table, value, path, axis) : read_list(value, path, axis)) {
      if (reaches(key, value, path)) {
        m_plan.axes.push_back(std::move(axis));
      }
    }
  }

  bool read_list(const Value& value, const std::string& path, SweepAxis& axis) {
    const Array* list = value.get<Array>();
    if (!list || list->empty() || list->size() > MAX_WEDGES) {
      refuse(value, path,
             fmt::format(": this is {}; expected a list of 1 to {} values or a range {{ from, to, count }}",
                         describe_type(value), MAX_WEDGES));
      return false;
    }
    axis.values = *list;
    return true;
  }

  bool read_range(const Table& table, const Value& value, const std::string& path, SweepAxis& axis) {
    const std::size_t before = m_diagnostics.count();
    Section section;
    section.fields = {number("from", "", any_number(), "The first value.").required(),
                      number("to", "", any_number(), "The last value.").required(),
                      integer("count", between(1, static_cast<double>(MAX_WEDGES)), "How many values."),
                      choice("scale", {{"linear", "", ""}, {"log", "", ""}}, "")};
    for (const Entry& entry : table.entries()) {
      const Field* field = section.find(entry.key);
      if (!field) {
        m_diagnostics.add(entry.key_place.source(path + "." + to_toml_key(excerpt(entry.key))),
                          ": there is no such key in a range" + suggestion(entry.key, section.keys()));
      } else {
        check_value(*field, entry.value, path + "." + entry.key, {}, {}, m_diagnostics);
      }
    }
    const Value *from = table.find("from"), *to = table.find("to"), *count = table.find("count");
    if (!from || !to || (!count && m_plan.mode != SweepMode::latin_hypercube)) {
      refuse(value, path,
             ": expected from, to and count, such as { from = 1e4, to = 1e6, count = 3, scale = \"log\" }");
    }
    if (m_diagnostics.count() > before) {
      return false;
    }
    const Value* scale = table.find("scale");
    SweepRange range{from->number(), to->number(), scale && *scale->get<std::string>() == "log"};
    if (range.logarithmic && !(range.from > 0.0 && range.to > 0.0)) {
      refuse(value, path, ": a logarithmic range needs from and to above 0");
      return false;
    }
    axis.range = range;
    if (m_plan.mode != SweepMode::latin_hypercube) {
      spread(range, static_cast<std::size_t>(count->number()), value.place, axis.values);
    }
    return true;
  }

  static void spread(const SweepRange& range, std::size_t count, const Place& place, std::vector<Value>& values) {
    for (std::size_t i = 0; i < count; ++i) {
      const double s = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0.0;
      const double exact = range.logarithmic ? range.from * std::pow(range.to / range.from, s)
                                             : range.from + (range.to - range.from) * s;
      values.emplace_back(i > 0 && i + 1 == count ? range.to : exact, place);
    }
  }

  /// Whether the key leads somewhere in this shot.
  bool reaches(const std::string& key, const Value& value, const std::string& path) {
    const bool refused =
        key == "extends" || key.rfind("sweep", 0) == 0 || key.rfind("accuracy", 0) == 0 || key.rfind("stress", 0) == 0;
    Status set = refused ? Status(make_error(ErrorCode::bad_input, "this key cannot be swept")) : check_schema_key(key);
    if (set) {
      set = check_key(m_root, key);
    }
    if (!set) {
      refuse(value, path, ": " + set.error().message);
    }
    return set.ok();
  }

  void read_cases(const Value& value) {
    const Array* cases = value.get<Array>();
    if (!cases || cases->size() > MAX_ITEMS) {
      refuse(value, "sweep.case",
             fmt::format(": this is {}; expected up to {} tables written [[sweep.case]]", describe_type(value),
                         MAX_ITEMS));
      return;
    }
    std::set<std::string> names;
    for (std::size_t i = 0; i < cases->size(); ++i) {
      read_case((*cases)[i], fmt::format("sweep.case[{}]", i), names);
    }
  }

  void read_case(const Value& value, const std::string& index_path, std::set<std::string>& names) {
    const Table* table = value.get<Table>();
    const Value* name = table ? table->find("name") : nullptr;
    const Value* set = table ? table->find("set") : nullptr;
    const Field field = plain("name", Kind::name, "");
    if (!name || !set || !set->get<Table>()) {
      refuse(value, index_path, ": expected name = \"...\" and set = { \"material.skin.model\" = ..., ... }");
      return;
    }
    if (!check_value(field, *name, index_path + ".name", {}, {}, m_diagnostics)) {
      return;
    }
    SweepCase sweep_case{*name->get<std::string>(), value.place.source("sweep.case." + *name->get<std::string>()), {}};
    for (const Entry& entry : table->entries()) {
      if (entry.key != "name" && entry.key != "set") {
        m_diagnostics.add(entry.key_place.source(sweep_case.source.key + "." + to_toml_key(excerpt(entry.key))),
                          ": there is no such key in a sweep case" + suggestion(entry.key, {"name", "set"}));
      }
    }
    if (!names.insert(sweep_case.name).second) {
      refuse(*name, sweep_case.source.key + ".name", " is taken: another [[sweep.case]] has this name");
    }
    collect(*set->get<Table>(), "", sweep_case);
    m_plan.cases.push_back(std::move(sweep_case));
  }

  /// Quoted keys are whole, unquoted ones become nested tables: a table is a value only where no key can go deeper.
  void collect(const Table& table, const std::string& prefix, SweepCase& sweep_case) {
    for (const Entry& entry : table.entries()) {
      const bool quoted_whole = prefix.empty() && entry.key.find('.') != std::string::npos;
      const std::string key = prefix.empty() ? entry.key : prefix + "." + entry.key;
      if (const Table* deeper = entry.value.get<Table>(); deeper && !quoted_whole) {
        collect(*deeper, key, sweep_case);
      } else if (reaches(key, entry.value, sweep_case.source.key + ".set." + to_toml_key(key))) {
        sweep_case.set.emplace_back(key, entry.value);
      }
    }
  }

  const Table& m_root;
  std::string m_section;
  Diagnostics& m_diagnostics;
  SweepPlan m_plan;
};

} // namespace

SweepPlan plan_sweep(const Table& root, Diagnostics& diagnostics) {
  return SweepReader(root, "sweep", diagnostics).read();
}

std::vector<SweepAxis> plan_axes(const Table& root, const std::string& section,
                                 const std::vector<std::string>& reserved, Diagnostics& diagnostics) {
  return SweepReader(root, section, diagnostics).read_axes(reserved);
}

} // namespace wry::shots
