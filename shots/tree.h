#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "shots/source.h"

/// The content of a TOML file as a plain tree that remembers where each value stood and keeps the order of the file.
namespace wry::shots {

/// Where a value stands, and how strong it is: of two layers the higher one wins.
struct Place {
  std::shared_ptr<const std::string> file;
  int line = 0, column = 0;
  Origin origin = Origin::standard;
  int layer = 0; ///< 0: defaults; then presets, the files of a chain of `extends`, the command line

  /// The same for people, with the whole key.
  Source source(std::string key) const;
};

class Value;
struct Entry;

/// Keys and values in the order of the file.
class Table {
public:
  const std::vector<Entry>& entries() const { return m_entries; }
  std::vector<Entry>& entries() { return m_entries; }
  bool empty() const { return m_entries.empty(); }
  const Value* find(std::string_view key) const; ///< nullptr: not there
  Value* find(std::string_view key);             ///< nullptr: not there
  const Entry* find_entry(std::string_view key) const;
  /// Replaces a value or appends it.
  void set(std::string key, Value value);
  void erase(std::string_view key);

private:
  std::vector<Entry> m_entries;
};

using Array = std::vector<Value>;

/// A value of a kind that no key takes, such as a date.
struct Unsupported {
  std::string text; ///< "a date"
};

class Value {
public:
  using Data = std::variant<bool, std::int64_t, double, std::string, Unsupported, Array, Table>;

  Value();
  explicit Value(bool data, Place where = {});
  explicit Value(std::int64_t data, Place where = {});
  explicit Value(double data, Place where = {});
  explicit Value(std::string data, Place where = {});
  explicit Value(Unsupported data, Place where = {});
  explicit Value(Array data, Place where = {});
  explicit Value(Table data, Place where = {});
  // Defined where the whole tree is known, and once: variants of trees are costly to compile.
  Value(const Value& other);
  Value(Value&& other) noexcept;
  Value& operator=(const Value& other);
  Value& operator=(Value&& other) noexcept;
  ~Value();

  template <class T> const T* get() const { return std::get_if<T>(&m_data); }
  template <class T> T* get() { return std::get_if<T>(&m_data); }
  bool is_number() const { return get<std::int64_t>() != nullptr || get<double>() != nullptr; }
  /// Of integers and floats; 0 of anything else.
  double number() const;

private:
  Data m_data;

public:
  Place place;
  std::string raw; ///< what stood on the command line; empty: a file
};

struct Entry {
  std::string key;
  Place key_place;
  Value value;
};

/// "a number", "text", "a table" ...: what was found, for messages.
std::string describe_type(const Value& value);

/// On one line, as TOML. Numbers keep all their digits.
std::string to_toml(const Value& value);
std::string to_toml(double number);
/// Quoted where TOML wants it.
std::string to_toml_key(std::string_view key);
/// In quotes, escaped.
std::string to_toml_text(std::string_view text);
/// to_toml, shortened for messages.
std::string excerpt(const Value& value);
std::string excerpt(std::string_view text);

} // namespace wry::shots
