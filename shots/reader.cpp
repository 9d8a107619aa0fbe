#include "shots/reader.h"

namespace wry::shots {
namespace {

const Table EMPTY_TABLE;

Vec3 to_vector(const Value& value) {
  Vec3 vector = Vec3::Zero();
  const auto* array = value.get<Array>();
  for (std::size_t i = 0; array && i < 3 && i < array->size(); ++i) {
    vector[static_cast<Eigen::Index>(i)] = (*array)[i].number();
  }
  return vector;
}

std::string join(const std::string& path, const std::string& key) {
  return path.empty() ? key : path + "." + key;
}

} // namespace

const Value* Reader::read(const std::string& key, Source& source) const {
  const Value* value = m_table->find(key);
  const std::string whole = join(m_path, key);
  source = value ? value->place.source(whole) : Source{{}, 0, 0, whole, Origin::standard};
  if (m_log) {
    m_log->insert(whole);
  }
  return value;
}

bool Reader::is_word(const std::string& key) const {
  const Value* value = m_table->find(key);
  return !value || value->get<std::string>() != nullptr;
}

Located<bool> Reader::boolean(const std::string& key) const {
  Located<bool> found;
  const Value* value = read(key, found.source);
  const bool* boolean = value ? value->get<bool>() : nullptr;
  found.value = boolean && *boolean;
  return found;
}

Located<std::int64_t> Reader::integer(const std::string& key) const {
  Located<std::int64_t> found;
  const Value* value = read(key, found.source);
  const auto* integer = value ? value->get<std::int64_t>() : nullptr;
  found.value = integer ? *integer : 0;
  return found;
}

Located<double> Reader::number(const std::string& key) const {
  Located<double> found;
  const Value* value = read(key, found.source);
  found.value = value ? value->number() : 0.0;
  return found;
}

Located<std::string> Reader::text(const std::string& key) const {
  Located<std::string> found;
  const Value* value = read(key, found.source);
  const auto* text = value ? value->get<std::string>() : nullptr;
  found.value = text ? *text : std::string();
  return found;
}

Located<Vec3> Reader::vector(const std::string& key) const {
  Located<Vec3> found{Vec3::Zero()};
  if (const Value* value = read(key, found.source)) {
    found.value = to_vector(*value);
  }
  return found;
}

Located<Mat3> Reader::columns(const std::string& key) const {
  Located<Mat3> found{Mat3::Zero()};
  const Value* value = read(key, found.source);
  const auto* array = value ? value->get<Array>() : nullptr;
  for (std::size_t i = 0; array && i < 3 && i < array->size(); ++i) {
    found.value.col(static_cast<Eigen::Index>(i)) = to_vector((*array)[i]);
  }
  return found;
}

Located<std::vector<double>> Reader::numbers(const std::string& key) const {
  Located<std::vector<double>> found;
  const Value* value = read(key, found.source);
  const auto* array = value ? value->get<Array>() : nullptr;
  for (std::size_t i = 0; array && i < array->size(); ++i) {
    found.value.push_back((*array)[i].number());
  }
  return found;
}

Source Reader::source_of(const std::string& key) const {
  const Value* value = m_table->find(key);
  const std::string whole = join(m_path, key);
  return value ? value->place.source(whole) : Source{{}, 0, 0, whole, Origin::standard};
}

bool Reader::differs(const std::string& key, const std::optional<Value>& standard) const {
  const Value* value = m_table->find(key);
  return value && !(standard && to_toml(*value) == to_toml(*standard));
}

Located<Expression> Reader::expression(const std::string& key) const {
  Located<Expression> found;
  if (const Value* value = read(key, found.source)) {
    if (value->is_number()) {
      found.value = Expression{to_toml(value->number()), value->number()};
    } else if (const auto* text = value->get<std::string>()) {
      found.value = Expression{*text, std::nullopt};
    }
  }
  return found;
}

std::optional<Located<double>> Reader::optional_number(const std::string& key) const {
  const Located<double> found = number(key);
  return is_word(key) ? std::nullopt : std::optional(found);
}

std::optional<Located<std::int64_t>> Reader::optional_integer(const std::string& key) const {
  const Located<std::int64_t> found = integer(key);
  return is_word(key) ? std::nullopt : std::optional(found);
}

std::optional<Located<std::string>> Reader::optional_text(const std::string& key) const {
  const Located<std::string> found = text(key);
  return has(key) ? std::optional(found) : std::nullopt;
}

std::optional<Located<Vec3>> Reader::optional_vector(const std::string& key) const {
  const Located<Vec3> found = vector(key);
  return has(key) ? std::optional(found) : std::nullopt;
}

Reader Reader::child(const std::string& key) const {
  Source ignored;
  const Value* value = read(key, ignored);
  const Table* table = value ? value->get<Table>() : nullptr;
  return Reader(table ? *table : EMPTY_TABLE, join(m_path, key), value ? value->place : Place{}, m_log);
}

std::vector<Reader> Reader::children(const std::string& key) const {
  Source ignored;
  const Value* value = read(key, ignored);
  const auto* array = value ? value->get<Array>() : nullptr;
  std::vector<Reader> readers;
  for (std::size_t i = 0; array && i < array->size(); ++i) {
    const Table* table = (*array)[i].get<Table>();
    const Value* name = table ? table->find("name") : nullptr;
    const std::string path = name && name->get<std::string>() ? join(join(m_path, key), *name->get<std::string>())
                                                              : fmt::format("{}[{}]", join(m_path, key), i);
    readers.emplace_back(table ? *table : EMPTY_TABLE, path, (*array)[i].place, m_log);
  }
  return readers;
}

std::vector<std::pair<std::string, Reader>> Reader::named_children(const std::string& key) const {
  std::vector<std::pair<std::string, Reader>> readers;
  const Reader parent = child(key);
  for (const Entry& entry : parent.m_table->entries()) {
    readers.emplace_back(entry.key, parent.child(entry.key));
  }
  return readers;
}

std::vector<Located<std::string>> Reader::texts(const std::string& key) const {
  Source source;
  const Value* value = read(key, source);
  const auto* array = value ? value->get<Array>() : nullptr;
  std::vector<Located<std::string>> list;
  for (std::size_t i = 0; array && i < array->size(); ++i) {
    if (const auto* text = (*array)[i].get<std::string>()) {
      const Place& place = (*array)[i].place.line > 0 ? (*array)[i].place : value->place;
      list.emplace_back(*text, place.source(source.key));
    }
  }
  return list;
}

} // namespace wry::shots
