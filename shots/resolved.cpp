#include "shots/resolved.h"

#include <filesystem>
#include <map>
#include <set>

#include "shots/resolved_tree.h"
#include "shots/schema.h"

namespace wry::shots {
namespace {

namespace fs = std::filesystem;

Effect effect_of(const Field& field, const Section* section, Effect around) {
  return field.effect.value_or(section && section->effect ? *section->effect : around);
}

/// Walks a checked table along its section and lists the leaves.
class Flattener {
public:
  explicit Flattener(std::vector<FlatKey>& keys)
      : m_keys(keys) {}

  void section(const Section& section, const Table& table, const std::string& path, Effect effect) {
    for (const Field& field : section.fields) {
      const Value* value = table.find(field.key);
      if (value && field.kind != Kind::free) {
        this->field(field, *value, path.empty() ? field.key : path + "." + field.key,
                    effect_of(field, field.section.get(), effect));
      }
    }
  }

private:
  void field(const Field& field, const Value& value, const std::string& path, Effect effect) {
    if (const Table* table = value.get<Table>()) {
      if (field.kind == Kind::table || field.kind == Kind::number) {
        section(*field.section, *table, path, effect);
        return;
      }
      for (const Entry& entry : table->entries()) {
        const std::string name = path + "." + entry.key;
        section(*field.section, *entry.value.get<Table>(), name, m_unused.contains(name) ? Effect::nothing : effect);
      }
    } else if (field.kind == Kind::named_list || field.kind == Kind::table_list) {
      const Array& items = *value.get<Array>();
      for (std::size_t i = 0; i < items.size(); ++i) {
        const Table& item = *items[i].get<Table>();
        const Value* name = field.kind == Kind::named_list ? item.find("name") : nullptr;
        section(*field.section, item, name ? path + "." + *name->get<std::string>() : fmt::format("{}[{}]", path, i),
                effect);
      }
    } else {
      m_keys.push_back(FlatKey{path, to_toml(value), effect});
    }
  }

  std::vector<FlatKey>& m_keys;

public:
  std::set<std::string> m_unused; ///< "material.skin": tables that nothing refers to
};

std::set<std::string> unused_tables(const Shot& shot) {
  std::set<std::string> unused;
  for (const Material& material : shot.materials) {
    unused.insert("material." + *material.name);
  }
  for (const Look& look : shot.looks) {
    unused.insert("look." + *look.name);
  }
  for (const Body& body : shot.bodies) {
    unused.erase("material." + *body.material);
    unused.erase("look." + (body.look ? **body.look : std::string()));
  }
  return unused;
}

/// Writes a checked tree as TOML, a header per table and the rest inline.
class Writer {
public:
  Writer(std::string shot_directory, std::string directory)
      : m_shot_directory(std::move(shot_directory))
      , m_directory(std::move(directory)) {}

  std::string write(const Table& root) {
    for (const Field& field : shot_schema().fields) {
      if (const Value* value = root.find(field.key)) {
        top(field, *value);
      }
    }
    return std::move(m_text);
  }

private:
  void top(const Field& field, const Value& value) {
    if (field.kind == Kind::named_list) {
      for (const Value& item : *value.get<Array>()) {
        m_text += fmt::format("\n[[{}]]\n", field.key);
        lines(*field.section, *item.get<Table>());
      }
    } else if (field.kind == Kind::named_tables) {
      for (const Entry& entry : value.get<Table>()->entries()) {
        m_text += fmt::format("\n[{}.{}]\n", field.key, to_toml_key(entry.key));
        lines(*field.section, *entry.value.get<Table>());
      }
    } else if (field.kind == Kind::table) {
      m_text += fmt::format("\n[{}]\n", field.key);
      lines(*field.section, *value.get<Table>());
    } else {
      m_text += fmt::format("\n[{}]\n", field.key);
      for (const Entry& entry : value.get<Table>()->entries()) {
        m_text += fmt::format("{} = {}\n", to_toml_key(entry.key), to_toml(entry.value));
      }
    }
  }

  void lines(const Section& section, const Table& table) {
    for (const Entry& entry : table.entries()) {
      const Field* field = section.find(entry.key);
      const bool is_path = field && field->kind == Kind::path;
      const bool is_empty = entry.value.get<Table>() && entry.value.get<Table>()->empty();
      if (!is_empty || (field && !field->default_note.empty())) {
        m_text += fmt::format("{} = {}\n", to_toml_key(entry.key),
                              is_path ? to_toml_text(moved(*entry.value.get<std::string>())) : to_toml(entry.value));
      }
    }
  }

  /// A path of the shot's folder as seen from the folder that the text is written to.
  std::string moved(const std::string& path) const {
    if (m_directory.empty() || fs::path(path).is_absolute()) {
      return path;
    }
    std::error_code ignored;
    const fs::path target = fs::absolute(fs::path(m_shot_directory) / path, ignored).lexically_normal();
    const fs::path base = fs::absolute(m_directory, ignored).lexically_normal();
    const fs::path relative = target.lexically_relative(base);
    return (relative.empty() ? target : relative).generic_string();
  }

  std::string m_shot_directory, m_directory, m_text;
};

} // namespace

std::vector<FlatKey> flatten(const Shot& shot) {
  std::vector<FlatKey> keys;
  if (!shot.resolved) {
    return keys;
  }
  Flattener flattener(keys);
  flattener.m_unused = unused_tables(shot);
  flattener.section(shot_schema(), shot.resolved->root, "", Effect::simulation);
  keys.push_back(FlatKey{"shot.frames.first", fmt::format("{}", shot.shot.frames->first()), Effect::simulation});
  return keys;
}

std::vector<KeyChange> compare(const std::vector<FlatKey>& before, const std::vector<FlatKey>& after) {
  std::map<std::string, const FlatKey*> old_keys;
  for (const FlatKey& key : before) {
    old_keys[key.key] = &key;
  }
  std::vector<KeyChange> changes;
  for (const FlatKey& key : after) {
    const auto found = old_keys.find(key.key);
    if (found == old_keys.end()) {
      changes.push_back(KeyChange{key.key, "", key.value, key.effect});
      continue;
    }
    const FlatKey& old_key = *found->second;
    // A material that becomes used matters although its values are the same.
    if (old_key.value != key.value || old_key.effect != key.effect) {
      changes.push_back(KeyChange{key.key, old_key.value, key.value, std::min(old_key.effect, key.effect)});
    }
    old_keys.erase(found);
  }
  for (const FlatKey& key : before) {
    if (old_keys.contains(key.key)) {
      changes.push_back(KeyChange{key.key, key.value, "", key.effect});
    }
  }
  return changes;
}

std::string write_resolved(const Shot& shot, const std::string& directory) {
  const std::string header = fmt::format("# {} with every default, preset and override written out.\n",
                                         fs::path(shot.file).filename().string());
  return shot.resolved ? header + Writer(shot.directory, directory).write(shot.resolved->root) : std::string();
}

} // namespace wry::shots
