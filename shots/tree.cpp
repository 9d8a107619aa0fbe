#include "shots/tree.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace wry::shots {

Source Place::source(std::string key) const {
  return Source{file ? *file : std::string(), line, column, std::move(key), origin};
}

const Entry* Table::find_entry(std::string_view key) const {
  const auto found = std::find_if(m_entries.begin(), m_entries.end(), [&](const Entry& e) { return e.key == key; });
  return found == m_entries.end() ? nullptr : &*found;
}

const Value* Table::find(std::string_view key) const {
  const Entry* entry = find_entry(key);
  return entry ? &entry->value : nullptr;
}

Value* Table::find(std::string_view key) {
  return const_cast<Value*>(std::as_const(*this).find(key));
}

void Table::set(std::string key, Value value) {
  for (Entry& entry : m_entries) {
    if (entry.key == key) {
      entry.key_place = value.place;
      entry.value = std::move(value);
      return;
    }
  }
  Place place = value.place;
  m_entries.push_back(Entry{std::move(key), std::move(place), std::move(value)});
}

void Table::erase(std::string_view key) {
  std::erase_if(m_entries, [&](const Entry& entry) { return entry.key == key; });
}

Value::Value()
    : m_data(false) {}
Value::Value(bool data, Place where)
    : m_data(data)
    , place(std::move(where)) {}
Value::Value(std::int64_t data, Place where)
    : m_data(data)
    , place(std::move(where)) {}
Value::Value(double data, Place where)
    : m_data(data)
    , place(std::move(where)) {}
Value::Value(std::string data, Place where)
    : m_data(std::move(data))
    , place(std::move(where)) {}
Value::Value(Unsupported data, Place where)
    : m_data(std::move(data))
    , place(std::move(where)) {}
Value::Value(Array data, Place where)
    : m_data(std::move(data))
    , place(std::move(where)) {}
Value::Value(Table data, Place where)
    : m_data(std::move(data))
    , place(std::move(where)) {}
Value::Value(const Value& other) = default;
Value::Value(Value&& other) noexcept = default;
Value& Value::operator=(const Value& other) = default;
Value& Value::operator=(Value&& other) noexcept = default;
Value::~Value() = default;

double Value::number() const {
  if (const auto* integer = get<std::int64_t>()) {
    return static_cast<double>(*integer);
  }
  const auto* floating = get<double>();
  return floating ? *floating : 0.0;
}

std::string describe_type(const Value& value) {
  if (const auto* array = value.get<Array>()) {
    const bool of_tables = !array->empty() && array->front().get<Table>() != nullptr;
    return fmt::format("a list of {}{}", array->size(), of_tables ? " tables" : "");
  }
  if (const auto* other = value.get<Unsupported>()) {
    return other->text;
  }
  return value.get<bool>()           ? "a boolean"
         : value.get<std::int64_t>() ? "an integer"
         : value.get<double>()       ? "a number"
         : value.get<std::string>()  ? "text"
                                     : "a table";
}

std::string to_toml(double number) {
  if (std::isnan(number)) {
    return "nan";
  }
  if (std::isinf(number)) {
    return number < 0 ? "-inf" : "inf";
  }
  std::string text = fmt::format("{}", number);
  if (text.find_first_of(".e") == std::string::npos) {
    text += ".0";
  }
  return text;
}

std::string to_toml_text(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      quoted += fmt::format("\\u{:04X}", byte);
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

std::string to_toml_key(std::string_view key) {
  const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
  return bare ? std::string(key) : to_toml_text(key);
}

std::string to_toml(const Value& value) {
  if (const auto* boolean = value.get<bool>()) {
    return *boolean ? "true" : "false";
  }
  if (const auto* integer = value.get<std::int64_t>()) {
    return fmt::format("{}", *integer);
  }
  if (const auto* number = value.get<double>()) {
    return to_toml(*number);
  }
  if (const auto* text = value.get<std::string>()) {
    return to_toml_text(*text);
  }
  std::string parts;
  if (const auto* array = value.get<Array>()) {
    for (const Value& item : *array) {
      parts += (parts.empty() ? "" : ", ") + to_toml(item);
    }
    return "[" + parts + "]";
  }
  if (const auto* table = value.get<Table>()) {
    for (const Entry& entry : table->entries()) {
      parts += fmt::format("{}{} = {}", parts.empty() ? "" : ", ", to_toml_key(entry.key), to_toml(entry.value));
    }
    return parts.empty() ? "{}" : "{ " + parts + " }";
  }
  return value.get<Unsupported>()->text;
}

std::string excerpt(std::string_view text) {
  constexpr std::size_t LONGEST = 60;
  std::string clean;
  for (const char c : text.substr(0, LONGEST)) {
    clean += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  if (text.size() <= LONGEST) {
    return clean;
  }
  // Not in the middle of a character of several bytes.
  while (!clean.empty() && (static_cast<unsigned char>(clean.back()) & 0xC0) == 0x80) {
    clean.pop_back();
  }
  if (!clean.empty() && (static_cast<unsigned char>(clean.back()) & 0x80) != 0) {
    clean.pop_back();
  }
  return clean + "...";
}

std::string excerpt(const Value& value) {
  return value.raw.empty() ? excerpt(to_toml(value)) : excerpt(value.raw);
}

} // namespace wry::shots
