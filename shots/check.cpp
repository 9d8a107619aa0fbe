#include "shots/check.h"

#include <algorithm>
#include <set>

#include <fmt/ranges.h>

#include "shots/nearest.h"
#include "shots/presets.h"

namespace wry::shots {
namespace {

/// The name of an item of an array table, if it has one that is text.
const std::string* name_of(const Value& item) {
  const auto* table = item.get<Table>();
  const Value* name = table ? table->find("name") : nullptr;
  return name ? name->get<std::string>() : nullptr;
}

std::vector<std::string> names_in(const Value& value) {
  std::vector<std::string> names;
  if (const auto* table = value.get<Table>()) {
    for (const Entry& entry : table->entries()) {
      names.push_back(entry.key);
    }
  } else if (const auto* array = value.get<Array>()) {
    for (const Value& item : *array) {
      if (const std::string* name = name_of(item)) {
        names.push_back(*name);
      }
    }
  }
  return names;
}

KnownNames known_names(const Table& root) {
  KnownNames names{{"look", list_built_in_looks()}};
  for (const Entry& entry : root.entries()) {
    if (entry.key != "sweep") {
      const std::vector<std::string> found = names_in(entry.value);
      names[entry.key].insert(names[entry.key].begin(), found.begin(), found.end());
    } else if (const auto* sweep = entry.value.get<Table>()) {
      if (const Value* cases = sweep->find("case")) {
        names["sweep.case"] = names_in(*cases);
      }
    }
  }
  return names;
}

class Checker {
public:
  Checker(KnownNames names, PathBase paths, Diagnostics& diagnostics)
      : m_names(std::move(names))
      , m_paths(std::move(paths))
      , m_diagnostics(diagnostics) {}

  Table table(const Section& section, Table given, const Place& place, const std::string& path) {
    const bool later = refuse_unknown(section, given, path);
    std::set<std::string> excluded;
    for (const OneOf& group : section.one_of) {
      const std::string winner = choose_alternative(group, given, place, path, later);
      drop_others(group, winner, given, excluded);
    }
    Table checked;
    for (const Field& field : section.fields) {
      const Entry* entry = given.find_entry(field.key);
      std::optional<Value> value =
          entry ? this->value(field, entry->value, join(path, field.key)) : absent(field, place, join(path, field.key));
      if (value && !excluded.contains(field.key)) {
        checked.set(field.key, std::move(*value));
      }
    }
    return checked;
  }

private:
  static std::string join(const std::string& path, const std::string& key) {
    return path.empty() ? key : path + "." + key;
  }

  /// Whether a key was met that a later build will have.
  bool refuse_unknown(const Section& section, const Table& given, const std::string& path) {
    bool later = false;
    for (const Entry& entry : given.entries()) {
      if (section.find(entry.key)) {
        continue;
      }
      const auto planned = std::find_if(section.later.begin(), section.later.end(),
                                        [&](const Later& key) { return key.key == entry.key; });
      const Source source = entry.key_place.source(join(path, to_toml_key(excerpt(entry.key))));
      if (planned != section.later.end()) {
        later = true;
        m_diagnostics.add(source, fmt::format(": this build has no {} yet; remove it", planned->what));
      } else if (!m_diagnostics.full()) {
        m_diagnostics.add(source, fmt::format(": there is no such key{}{}", path.empty() ? "" : " in " + path,
                                              suggest_key(entry.key, section)));
      } else {
        m_diagnostics.add(source, "");
      }
    }
    return later;
  }

  /// Keys of later builds are named when they are meant, but not offered.
  static std::string suggest_key(const std::string& word, const Section& section) {
    std::vector<std::string> candidates = section.keys();
    for (const Later& later : section.later) {
      candidates.push_back(later.key);
    }
    return nearest(word, candidates).empty() ? suggestion(word, section.keys()) : suggestion(word, candidates);
  }

  /// Of keys that exclude each other the ones of the strongest layer stay: a key of those, or nothing.
  std::string choose_alternative(const OneOf& group, Table& given, const Place& place, const std::string& path,
                                 bool later) {
    int strongest = -1;
    std::vector<const Entry*> winners; // the first entry of each alternative of the strongest layer
    for (const std::vector<std::string>& alternative : group.alternatives) {
      const Entry* best = nullptr;
      for (const std::string& key : alternative) {
        const Entry* entry = given.find_entry(key);
        if (entry && (!best || entry->value.place.layer > best->value.place.layer)) {
          best = entry;
        }
      }
      if (best && best->value.place.layer >= strongest) {
        if (best->value.place.layer > strongest) {
          winners.clear();
        }
        strongest = best->value.place.layer;
        winners.push_back(best);
      }
    }
    if (winners.size() > 1) {
      m_diagnostics.add(winners[1]->key_place.source(join(path, winners[1]->key)),
                        fmt::format(": {} is given already by {} (line {}); keep one of the two", group.what,
                                    winners[0]->key, winners[0]->key_place.line));
    } else if (winners.empty() && group.is_required && !later) {
      std::vector<std::string> keys;
      for (const std::vector<std::string>& alternative : group.alternatives) {
        keys.push_back(alternative.front());
      }
      m_diagnostics.add(place.source(path),
                        fmt::format(": the {} is missing; give one of {}", group.what, fmt::join(keys, ", ")));
    }
    return winners.empty() ? std::string() : winners.front()->key;
  }

  static void drop_others(const OneOf& group, const std::string& winner, Table& given,
                          std::set<std::string>& excluded) {
    for (const std::vector<std::string>& alternative : group.alternatives) {
      const bool lost = std::find(alternative.begin(), alternative.end(), winner) == alternative.end();
      for (const std::string& key : alternative) {
        if (lost) {
          given.erase(key);
        }
        // Without a winner the defaults hold, but no table of an alternative springs up by itself.
        if (lost && (!winner.empty() || group.is_required)) {
          excluded.insert(key);
        }
      }
    }
  }

  /// What stands for a key that nobody gave.
  std::optional<Value> absent(const Field& field, const Place& place, const std::string& key) {
    if (field.is_required) {
      if (!m_lenient) {
        m_diagnostics.add(place.source(key),
                          fmt::format(" is missing: {} Expected {}.", field.doc, expectation(field)));
      }
      return std::nullopt;
    }
    if (field.kind == Kind::table && field.default_note.empty() && can_be_empty(*field.section)) {
      return Value(table(*field.section, Table(), place, key));
    }
    return field.value;
  }

  std::optional<Value> value(const Field& field, const Value& given, const std::string& key) {
    switch (field.kind) {
    case Kind::table:
      return nested(field, given, key);
    case Kind::table_list:
      return table_list(field, given, key);
    case Kind::named_list:
      return named_list(field, given);
    case Kind::named_tables:
      return named_tables(field, given, key);
    case Kind::free:
      if (!given.get<Table>()) {
        return mistyped(field, given, key);
      }
      return given;
    default:
      return field.section && given.get<Table>() ? nested(field, given, key)
                                                 : check_value(field, given, key, m_names, m_paths, m_diagnostics);
    }
  }

  std::optional<Value> mistyped(const Field& field, const Value& given, const std::string& key) {
    m_diagnostics.add(given.place.source(key),
                      fmt::format(": this is {}; expected {}", describe_type(given), expectation(field)));
    return std::nullopt;
  }

  std::optional<Value> nested(const Field& field, const Value& given, const std::string& key) {
    const auto* content = given.get<Table>();
    return content ? std::optional(Value(table(*field.section, *content, given.place, key), given.place))
                   : mistyped(field, given, key);
  }

  std::optional<Value> table_list(const Field& field, const Value& given, const std::string& key) {
    const Array single{given};
    const Array* items = given.get<Table>() ? &single : given.get<Array>();
    if (!items || items->size() > 64) {
      return mistyped(field, given, key);
    }
    Array checked;
    for (const Value& item : *items) {
      if (std::optional<Value> entry = nested(field, item, fmt::format("{}[{}]", key, checked.size()))) {
        checked.push_back(std::move(*entry));
      } else {
        return std::nullopt;
      }
    }
    return Value(std::move(checked), given.place);
  }

  std::optional<Value> named_list(const Field& field, const Value& given) {
    const auto* items = given.get<Array>();
    if (!items) {
      return mistyped(field, given, field.key);
    }
    if (!few_enough(items->size(), given, field.key)) {
      return std::nullopt;
    }
    Array checked;
    std::map<std::string, int> lines;
    for (std::size_t i = 0; i < items->size(); ++i) {
      const Value& item = (*items)[i];
      const std::string* name = name_of(item);
      const bool safe = name && is_safe_name(*name, Dots::refused);
      const std::string path = safe ? join(field.key, *name) : fmt::format("{}[{}]", field.key, i);
      if (!item.get<Table>()) {
        mistyped(field, item, path);
        continue;
      }
      if (safe && !lines.emplace(*name, item.place.line).second) {
        const Place& given_name = item.get<Table>()->find("name")->place;
        m_diagnostics.add((given_name.line > 0 ? given_name : item.place).source(path + ".name"),
                          fmt::format(" is taken: another [[{}]] in line {} has this name; names tell things apart",
                                      field.key, lines[*name]));
      }
      checked.push_back(Value(table(*field.section, *item.get<Table>(), item.place, path), item.place));
    }
    return Value(std::move(checked), given.place);
  }

  bool few_enough(std::size_t count, const Value& given, const std::string& key) {
    if (count > MAX_ITEMS) {
      m_diagnostics.add(given.place.source(key),
                        fmt::format(": {} of them; at most {} are possible", count, MAX_ITEMS));
    }
    return count <= MAX_ITEMS;
  }

  std::optional<Value> named_tables(const Field& field, const Value& given, const std::string& key) {
    const auto* tables = given.get<Table>();
    if (!tables) {
      return mistyped(field, given, key);
    }
    if (!few_enough(tables->entries().size(), given, key)) {
      return std::nullopt;
    }
    Table checked;
    for (const Entry& entry : tables->entries()) {
      if (!is_safe_name(entry.key, Dots::refused)) {
        m_diagnostics.add(entry.key_place.source(join(key, to_toml_key(excerpt(entry.key)))),
                          ": expected a name of letters, digits, _ and -; it becomes part of keys and file names");
        continue;
      }
      const std::string path = join(key, entry.key);
      if (const auto* content = entry.value.get<Table>()) {
        checked.set(entry.key, Value(with_preset(field, *content, entry.value.place, path), entry.value.place));
      } else {
        m_diagnostics.add(entry.value.place.source(path),
                          fmt::format(": this is {}; expected a table [{}] with {}", describe_type(entry.value), path,
                                      fmt::join(field.section->keys(), ", ")));
      }
    }
    return Value(std::move(checked), given.place);
  }

  /// The table with its preset's values where it has none of its own.
  Table with_preset(const Field& field, Table content, const Place& place, const std::string& path) {
    const Value* preset = content.find("preset");
    const std::string* name = preset ? preset->get<std::string>() : nullptr;
    if (name && field.section->find("preset")) {
      const Table values = preset_values(*name);
      for (const Entry& entry : values.entries()) {
        if (!content.find(entry.key)) {
          content.set(entry.key, entry.value);
        }
      }
      m_lenient = values.empty(); // an unknown preset is one error, not one for each value it would have brought
    }
    Table checked = table(*field.section, std::move(content), place, path);
    m_lenient = false;
    return checked;
  }

  KnownNames m_names;
  PathBase m_paths;
  Diagnostics& m_diagnostics;
  bool m_lenient = false;
};

} // namespace

bool can_be_empty(const Section& section) {
  const bool free_fields =
      std::none_of(section.fields.begin(), section.fields.end(), [](const Field& field) { return field.is_required; });
  return free_fields && std::none_of(section.one_of.begin(), section.one_of.end(),
                                     [](const OneOf& group) { return group.is_required; });
}

Table check_document(const ShotDocument& document, Diagnostics& diagnostics) {
  Table root = document.root();
  fill_derived_defaults(root, document.file());
  Checker checker(known_names(root), PathBase{document.file(), document.directory()}, diagnostics);
  const Place place{std::make_shared<const std::string>(document.file()), 1, 1, Origin::file, 0};
  Table checked = checker.table(shot_schema(), std::move(root), place, "");
  fill_rod_heights(checked);
  return checked;
}

} // namespace wry::shots
