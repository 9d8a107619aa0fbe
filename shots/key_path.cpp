#include "shots/key_path.h"

#include <charconv>

#include "shots/load.h"
#include "shots/nearest.h"

namespace wry::shots {
namespace {

std::vector<std::string> names_of(const Array& list) {
  std::vector<std::string> names;
  for (const Value& item : list) {
    const Table* table = item.get<Table>();
    const Value* name = table ? table->find("name") : nullptr;
    if (name && name->get<std::string>()) {
      names.push_back(*name->get<std::string>());
    }
  }
  return names;
}

/// The place of an item by its name, or by its index where items have no names.
Result<std::size_t> find_item(const Array& list, const std::string& part, const std::string& path) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Table* table = list[i].get<Table>();
    const Value* name = table ? table->find("name") : nullptr;
    if (name && name->get<std::string>() && *name->get<std::string>() == part) {
      return i;
    }
  }
  const std::vector<std::string> names = names_of(list);
  if (!names.empty()) {
    return make_error(ErrorCode::bad_input, "there is no [[{}]] named '{}'{}", path, excerpt(part),
                      suggestion(part, names));
  }
  std::size_t index = 0;
  const auto [end, problem] = std::from_chars(part.data(), part.data() + part.size(), index);
  if (problem != std::errc{} || end != part.data() + part.size() || index >= list.size()) {
    return make_error(ErrorCode::bad_input, "'{}' is no index into {}, a list of {}", excerpt(part), path, list.size());
  }
  return index;
}

/// The value that a key leads to; nullptr where it, or a table on the way, would have to be made.
Result<const Value*> walk(const Table& root, const std::vector<std::string>& parts) {
  const Table* table = &root;
  const Array* list = nullptr;
  std::string path;
  for (std::size_t i = 0;; ++i) {
    const Value* next = nullptr;
    if (list) {
      const Result<std::size_t> item = find_item(*list, parts[i], path);
      if (!item) {
        return item.error();
      }
      next = &(*list)[*item];
    } else {
      next = table->find(parts[i]);
    }
    if (!next || i + 1 == parts.size()) {
      return next;
    }
    path += (path.empty() ? "" : ".") + parts[i];
    list = next->get<Array>();
    table = next->get<Table>();
    if (!list && !table) {
      return make_error(ErrorCode::bad_input, "{} is {}, so it has no '{}'", path, describe_type(*next),
                        excerpt(parts[i + 1]));
    }
  }
}

} // namespace

Result<std::vector<std::string>> split_key(std::string_view key) {
  std::vector<std::string> parts(1);
  bool was_quoted = false;
  for (std::size_t i = 0; i < key.size(); ++i) {
    const char c = key[i];
    if (c == '.') {
      if (parts.back().empty() && !was_quoted) {
        break;
      }
      parts.emplace_back();
      was_quoted = false;
    } else if ((c == '"' || c == '\'') && parts.back().empty() && !was_quoted) {
      const auto end = key.find(c, i + 1);
      if (end == std::string_view::npos) {
        return make_error(ErrorCode::bad_input, "the key '{}' has a quote that does not end", excerpt(key));
      }
      parts.back() = std::string(key.substr(i + 1, end - i - 1));
      was_quoted = true;
      i = end;
    } else {
      parts.back() += c;
    }
  }
  if (parts.back().empty() && !was_quoted) {
    return make_error(ErrorCode::bad_input, "the key '{}' has an empty part; expected a key such as shot.frames",
                      excerpt(key));
  }
  if (parts.size() > static_cast<std::size_t>(MAX_DEPTH)) {
    return make_error(ErrorCode::bad_input, "the key '{}' has more than {} parts", excerpt(key), MAX_DEPTH);
  }
  return parts;
}

Status check_key(const Table& root, std::string_view key) {
  const Result<std::vector<std::string>> parts = split_key(key);
  if (!parts) {
    return parts.error();
  }
  const Result<const Value*> found = walk(root, *parts);
  return found ? Status() : Status(found.error());
}

Status set_at(Table& root, std::string_view key, Value value) {
  const Result<std::vector<std::string>> parts = split_key(key);
  if (!parts) {
    return parts.error();
  }
  const Result<const Value*> found = walk(root, *parts);
  if (!found) {
    return found.error();
  }
  if (*found) {
    *const_cast<Value*>(*found) = std::move(value); // the tree is ours to change
    return {};
  }
  Table* table = &root;
  for (std::size_t i = 0; i < parts->size(); ++i) {
    const std::string& part = (*parts)[i];
    if (i + 1 == parts->size()) {
      table->set(part, std::move(value));
      break;
    }
    if (!table->find(part)) {
      table->set(part, Value(Table(), value.place));
    }
    Value* next = table->find(part);
    if (Array* list = next->get<Array>()) {
      next = &(*list)[*find_item(*list, (*parts)[++i], part)];
    }
    table = next->get<Table>();
  }
  return {};
}

} // namespace wry::shots
