#include <filesystem>
#include <fstream>
#include <set>

#include "shots/check.h"
#include "shots/load.h"
#include "shots/toml_reader.h"

namespace wry::shots {
namespace {

namespace fs = std::filesystem;

constexpr int MAIN_LAYER = 50; // what a file extends is weaker by one per step

std::string folder_of(const std::string& path) {
  const std::string folder = fs::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

Result<std::string> read_text(const std::string& path, const std::string& asked_by) {
  std::error_code problem;
  const fs::file_status status = fs::status(path, problem);
  if (!fs::exists(status)) {
    return make_error(ErrorCode::missing_input, "{}{}: there is no such shot file", asked_by, path);
  }
  if (!fs::is_regular_file(status)) {
    return make_error(ErrorCode::bad_input, "{}{}: this is no file; expected a shot file (TOML)", asked_by, path);
  }
  std::ifstream stream(path, std::ios::binary);
  std::string text(MAX_FILE_BYTES + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!stream.is_open() || stream.bad()) {
    return make_error(ErrorCode::io, "{}{}: cannot be read; are its permissions right?", asked_by, path);
  }
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

/// By name: items of the same name are merged, the others appended.
void merge_list(Array& base, Array over);

enum class Level { root, below };

void merge_table(Table& base, Table over, Level level) {
  for (Entry& entry : over.entries()) {
    Value* below = base.find(entry.key);
    Table* tables[] = {below ? below->get<Table>() : nullptr, entry.value.get<Table>()};
    Array* lists[] = {below ? below->get<Array>() : nullptr, entry.value.get<Array>()};
    const Field* field = level == Level::root ? shot_schema().find(entry.key) : nullptr;
    const bool named = (field && field->kind == Kind::named_list) || entry.key == "case";
    if (tables[0] && tables[1]) {
      merge_table(*tables[0], std::move(*tables[1]), Level::below);
      below->place = entry.value.place;
    } else if (lists[0] && lists[1] && named) {
      merge_list(*lists[0], std::move(*lists[1]));
      below->place = entry.value.place;
    } else {
      base.set(entry.key, std::move(entry.value));
    }
  }
}

void merge_list(Array& base, Array over) {
  const auto name_of = [](Value& item) -> const std::string* {
    Table* table = item.get<Table>();
    Value* name = table ? table->find("name") : nullptr;
    return name ? name->get<std::string>() : nullptr;
  };
  const std::size_t inherited = base.size();
  for (Value& item : over) {
    const std::string* name = name_of(item);
    Value* same = nullptr;
    for (std::size_t i = 0; name && !same && i < inherited; ++i) {
      const std::string* other = name_of(base[i]);
      same = other && *other == *name ? &base[i] : nullptr;
    }
    if (same) {
      same->place = item.place;
      merge_table(*same->get<Table>(), std::move(*item.get<Table>()), Level::below);
    } else {
      base.push_back(std::move(item));
    }
  }
}

/// Reads a chain of files that extend each other.
class Extender {
public:
  Result<Table> resolve(std::string_view text, const std::string& file, const std::string& folder, int depth) {
    Result<Table> parsed = parse_toml(text, file, MAIN_LAYER - depth);
    if (!parsed) {
      return parsed;
    }
    const Value* extends = parsed->find("extends");
    if (!extends) {
      return parsed;
    }
    Result<Table> base = read_base(*extends, folder, depth);
    if (!base) {
      return base;
    }
    parsed->erase("extends");
    merge_table(*base, std::move(*parsed), Level::root);
    return base;
  }

  void visit(const std::string& path) { m_visited.insert(identity(path)); }

private:
  static std::string identity(const std::string& path) {
    std::error_code ignored;
    const fs::path canonical = fs::weakly_canonical(path, ignored);
    return canonical.empty() ? path : canonical.string();
  }

  Result<Table> read_base(const Value& extends, const std::string& folder, int depth) {
    const std::string where = extends.place.source("extends").text();
    const auto* name = extends.get<std::string>();
    if (!name || name->empty() || name->find('\0') != std::string::npos) {
      return make_error(ErrorCode::bad_input, "{} = {}: this is {}; expected the path of a shot file", where,
                        excerpt(extends), describe_type(extends));
    }
    const std::string path = (fs::path(folder) / *name).lexically_normal().string();
    if (depth + 1 >= MAX_EXTENDS) {
      return make_error(ErrorCode::bad_input, "{} = {}: more than {} files extend each other; merge some", where,
                        excerpt(extends), MAX_EXTENDS);
    }
    if (!m_visited.insert(identity(path)).second) {
      return make_error(ErrorCode::bad_input, "{} = {}: the files extend each other in a circle; remove one `extends`",
                        where, excerpt(extends));
    }
    const Result<std::string> text = read_text(path, where + " = " + excerpt(extends) + ": ");
    return text ? resolve(*text, path, folder_of(path), depth + 1) : Result<Table>(text.error());
  }

  std::set<std::string> m_visited;
};

Result<ShotDocument> make_document(Result<Table> root, const std::string& file, const std::string& directory) {
  if (!root) {
    return root.error();
  }
  name_unnamed(*root);
  return ShotDocument(file, directory, std::make_shared<const Table>(std::move(*root)));
}

} // namespace

Result<ShotDocument> read_document(const std::string& path) {
  const Result<std::string> text = read_text(path, "");
  if (!text) {
    return text.error();
  }
  Extender extender;
  extender.visit(path);
  return make_document(extender.resolve(*text, path, folder_of(path), 0), path, folder_of(path));
}

Result<ShotDocument> read_document_text(std::string_view text, const std::string& file, const std::string& directory) {
  Extender extender;
  return make_document(extender.resolve(text, file, directory, 0), file, directory);
}

} // namespace wry::shots
