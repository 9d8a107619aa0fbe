#pragma once

#include <array>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "shots/shot.h"
#include "shots/tree.h"

namespace wry::shots {

/// Keys that were read, so that a test can find the ones that the schema has and nobody reads.
using ReadLog = std::set<std::string>;

/// Reads typed values from a checked table. What is not there, because it was wrong or is optional, reads as T{}.
class Reader {
public:
  Reader(const Table& table, std::string path, Place place, ReadLog* log)
      : m_table(&table)
      , m_path(std::move(path))
      , m_place(std::move(place))
      , m_log(log) {}

  Source source() const { return m_place.source(m_path); }
  const std::string& path() const { return m_path; }
  /// Where a key stands, without reading it.
  Source source_of(const std::string& key) const;
  /// Whether a key is there and has another value than this, without reading it.
  bool differs(const std::string& key, const std::optional<Value>& standard) const;
  bool has(const std::string& key) const { return m_table->find(key) != nullptr; }

  Located<bool> boolean(const std::string& key) const;
  Located<std::int64_t> integer(const std::string& key) const;
  Located<double> number(const std::string& key) const;
  Located<std::string> text(const std::string& key) const;
  Located<Vec3> vector(const std::string& key) const;
  Located<Mat3> columns(const std::string& key) const; ///< a list per column
  Located<std::vector<double>> numbers(const std::string& key) const;
  Located<Expression> expression(const std::string& key) const;

  /// nullopt: absent, or the word that stands for "auto".
  std::optional<Located<double>> optional_number(const std::string& key) const;
  std::optional<Located<std::int64_t>> optional_integer(const std::string& key) const;
  std::optional<Located<std::string>> optional_text(const std::string& key) const;
  std::optional<Located<Vec3>> optional_vector(const std::string& key) const;

  template <std::size_t N> Located<std::array<std::int64_t, N>> integers(const std::string& key) const {
    Located<std::array<std::int64_t, N>> list;
    if (const Value* value = read(key, list.source)) {
      const auto* array = value->get<Array>();
      for (std::size_t i = 0; array && i < N && i < array->size(); ++i) {
        list.value[i] = static_cast<std::int64_t>((*array)[i].number());
      }
    }
    return list;
  }

  /// The entry of `words` that the key names.
  template <class E>
  Located<E> choice(const std::string& key, std::initializer_list<std::pair<const char*, E>> words) const {
    const Located<std::string> word = text(key);
    for (const auto& [name, meaning] : words) {
      if (*word == name) {
        return {meaning, word.source};
      }
    }
    return {E{}, word.source};
  }

  /// A nested table; empty when it is not there.
  Reader child(const std::string& key) const;
  /// The tables of a list; `named`: each is known by its name, else by its index.
  std::vector<Reader> children(const std::string& key) const;
  /// The tables below a table with their names.
  std::vector<std::pair<std::string, Reader>> named_children(const std::string& key) const;
  /// The words of a list.
  std::vector<Located<std::string>> texts(const std::string& key) const;

private:
  const Value* read(const std::string& key, Source& source) const;
  bool is_word(const std::string& key) const;

  const Table* m_table;
  std::string m_path;
  Place m_place;
  ReadLog* m_log;
};

} // namespace wry::shots
